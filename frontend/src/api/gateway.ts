/** The way to the gateway: every request goes through `send`, and every refusal becomes a `Problem` here. */
import createClient, { type Middleware } from "openapi-fetch";
import { NOT_SENT, Problem, problemOf } from "./problem";
import { tellLoggedOut } from "./session";
import { worded } from "./problem-words";
import type { paths } from "./types";

/** Longer than the gateway ever needs to write an order down. */
const PATIENCE_MS = 10_000;

const refusals: Middleware = {
  async onResponse({ response, options }) {
    if (response.ok) return;
    // Who is known at the way for stops is known from memory: only the gateway itself says who is logged in.
    if (response.status === 401 && options.baseUrl === "") tellLoggedOut();
    throw await worded(problemOf(response.status, await response.json().catch(() => null)));
  },
  onError({ error }) {
    // Browsers do not tell a connection that was refused from one that was cut: only patience that has ended is told.
    const late = error instanceof DOMException && error.name === "TimeoutError";
    return new Problem(0, "", [], late ? "" : NOT_SENT);
  },
};

/** Beside the API, and so not in its document. */
interface Pages {
  "/logout": { post: { responses: { 204: { content?: never } } } };
}

export const gateway = createClient<paths & Pages, "application/json">({
  headers: { Accept: "application/json" },
  credentials: "same-origin",
  fetch: (request) => fetch(request, { signal: AbortSignal.timeout(PATIENCE_MS) }),
});
gateway.use(refusals);

/**
 * The body of an answer.
 *
 * @throws Problem whatever kept it away
 */
export async function bodyOf<T>(call: Promise<{ data?: T }>): Promise<Exclude<T, undefined>> {
  try {
    const { data } = await call;
    if (data !== undefined) return data as Exclude<T, undefined>;
  } catch (error) {
    if (error instanceof Problem) throw error;
    // The answer has begun, so the request has arrived; what became of it is not known.
  }
  throw new Problem(0, "");
}
