/** What the management panel says of what is chosen, in German. */
import type { Catalogue } from "../../catalogue";
import type { story as en } from "../en/story";

export const story: Catalogue<typeof en> = {
  "story.label": "Was gewählt ist",
  "story.none": "Wählen Sie etwas auf der Karte oder in einer Liste: Alles, was dazugehört, wird zusammen gezeigt.",
  "story.unknown": "In diesem Werk heißt nichts {id}.",
  "story.transport": "Transport",
  "story.production": "Fertigungsauftrag",
  "story.vehicle": "Fahrzeug",
  "story.standby": "Sekundär",
  "story.machine": "Maschine",
  "story.place": "Ort",
  "story.called": "Gerufen",
  "story.order": "Auftrag",
  "story.follow": "Folgen",
  "story.followTitle": "Karte und Felder gehen mit dem Gewählten mit, bis jemand die Karte bewegt",
  "story.copy": "Link kopieren",
  "story.copied": "Kopiert",
  "story.notCopied": "Bitte aus der Adresszeile nehmen",
  "legend.open": "Legende",
  "legend.title": "Was die Zeichen der Karte bedeuten",
  "tour.again": "Rundgang zeigen",
  "orderPage.show": "Auf der Karte zeigen",
};
