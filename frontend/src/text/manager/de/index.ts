/** The management panel in German. */
import type { Catalogue } from "../../catalogue";
import type { en } from "../en";
import { de as shared } from "../../shared/de";
import { auction } from "./auction";
import { orders } from "./orders";
import { panel } from "./panel";
import { records } from "./records";
import { story } from "./story";

export const de: Catalogue<typeof en> = {
  ...shared,
  ...panel,
  ...orders,
  ...auction,
  ...records,
  ...story,
};
