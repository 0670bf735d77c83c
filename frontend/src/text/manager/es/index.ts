/** The management panel in Spanish. */
import type { Catalogue } from "../../catalogue";
import type { en } from "../en";
import { es as shared } from "../../shared/es";
import { auction } from "./auction";
import { orders } from "./orders";
import { panel } from "./panel";
import { records } from "./records";
import { story } from "./story";

export const es: Catalogue<typeof en> = {
  ...shared,
  ...panel,
  ...orders,
  ...auction,
  ...records,
  ...story,
};
