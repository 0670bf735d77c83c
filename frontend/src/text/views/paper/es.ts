import type { Catalogue } from "../../catalogue";
import type { paper as en } from "./en";

/** What lists say of being printed, in Spanish. */
export const paper: Catalogue<typeof en> = {
  "paper.print": "Imprimir",
  "paper.printTitle": "Imprimir todo lo que encuentra el filtro, no solo esta página",
  "paper.reading": "Leyendo… {n}",
  "paper.all": "Los {n} que encuentra el filtro, impresos {at}",
  "paper.first": "Los primeros {n} que encuentra el filtro; hay más. Limite la lista o use el archivo CSV. Impreso {at}",
  "paper.screen": "Solo la página de la pantalla: el botón Imprimir imprime todo lo que encuentra el filtro.",
  "paper.failed": "No se imprimió: {reason}",
};
