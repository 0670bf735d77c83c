/** The management panel in English. `{names}` are filled in; `.one` and `.other` follow a count. */
import { en as shared } from "../../shared/en";
import { auction } from "./auction";
import { orders } from "./orders";
import { panel } from "./panel";
import { records } from "./records";
import { story } from "./story";

export const en = {
  ...shared,
  ...panel,
  ...orders,
  ...auction,
  ...records,
  ...story,
} as const;
