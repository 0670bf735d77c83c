/** The operator panel in German. */
import type { Catalogue } from "../catalogue";
import { de as shared } from "../shared/de";
import type { en } from "./en";

export const de: Catalogue<typeof en> = {
  ...shared,

  "app.title": "Dray – Arbeitsplatz",
};
