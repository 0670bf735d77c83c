/** The operator panel in English. `{names}` are filled in; `.one` and `.other` follow a count. */
import { en as shared } from "../shared/en";

export const en = {
  ...shared,

  "app.title": "Dray – station",
} as const;
