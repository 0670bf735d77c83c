/** The management panel in English. `{names}` are filled in; `.one` and `.other` follow a count. */
import { en as shared } from "../../shared/en";
import { auction } from "./auction";
import { orders } from "./orders";
import { panel } from "./panel";
import { records } from "./records";
import { scenario } from "./scenario";

export const en = {
  ...shared,
  ...panel,
  ...orders,
  ...auction,
  ...records,
  ...scenario,
} as const;
