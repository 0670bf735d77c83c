/** What is said of the pieces of a machine, loaded when somebody looks at one, in Spanish. */
import type { Catalogue } from "../../catalogue";
import type { pieces as en } from "./en";

export const pieces: Catalogue<typeof en> = {
  "pieces.since": "Piezas desde las {since}",
  "pieces.none": "No se ha terminado ninguna pieza desde las {since}.",
  "pieces.product": "Producto",
  "pieces.good": "Buenas",
  "pieces.bad": "Malas",
  "pieces.ratio": "Calidad",
};
