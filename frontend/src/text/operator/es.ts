/** The operator panel in Spanish. */
import type { Catalogue } from "../catalogue";
import { es as shared } from "../shared/es";
import type { en } from "./en";

export const es: Catalogue<typeof en> = {
  ...shared,

  "app.title": "Dray – puesto",
};
