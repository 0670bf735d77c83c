/** What is said of the pieces of a machine, loaded when somebody looks at one, in German. */
import type { Catalogue } from "../../catalogue";
import type { pieces as en } from "./en";

export const pieces: Catalogue<typeof en> = {
  "pieces.since": "Stücke seit {since}",
  "pieces.none": "Seit {since} wurde kein Stück fertig.",
  "pieces.product": "Produkt",
  "pieces.good": "Gut",
  "pieces.bad": "Schlecht",
  "pieces.ratio": "Qualität",
};
