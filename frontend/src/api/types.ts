/** What the gateway is asked and answers, as its OpenAPI document tells it; `npm run types` writes that as TypeScript. */
export type * from "../../generated/openapi";
