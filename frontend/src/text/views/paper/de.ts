import type { Catalogue } from "../../catalogue";
import type { paper as en } from "./en";

/** What lists say of being printed, in German. */
export const paper: Catalogue<typeof en> = {
  "paper.print": "Drucken",
  "paper.printTitle": "Alles drucken, was der Filter findet, nicht nur diese Seite",
  "paper.reading": "Wird gelesen… {n}",
  "paper.all": "Alle {n}, die der Filter findet, gedruckt {at}",
  "paper.first": "Die ersten {n}, die der Filter findet; es gibt mehr. Die Liste enger fassen oder die CSV-Datei nehmen. Gedruckt {at}",
  "paper.screen": "Nur die Seite auf dem Bildschirm: Der Knopf Drucken druckt alles, was der Filter findet.",
  "paper.failed": "Nicht gedruckt: {reason}",
};
