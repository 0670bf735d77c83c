/** What the management panel says of people and of every list, in German. */
import type { Catalogue } from "../../catalogue";
import type { records as english } from "../en/records";

export const records: Catalogue<typeof english> = {
  "person.menu": "Wer hier arbeitet",
  "person.logOut": "Abmelden",
  "person.role.manager": "Leitung",
  "person.role.operator": "Bediener",
  "person.role.admin": "Administrator",
  "person.role.key": "Schlüssel eines anderen Systems",

  "audit.title": "Protokoll",

  "filter.find": "In dieser Liste suchen",
  "filter.any": "alle",
  "filter.open": "offen",
  "filter.inProduction": "eingeplant oder in Fertigung",
  "filter.none": "Nichts Passendes.",
  "filter.csv": "CSV",
  "filter.csvTitle": "Für eine Tabelle herunterladen",

  "watch.title": "Wache",

  "promises.title": "Zusagen",

  "kpis.title": "Kennzahlen im Verlauf",
  "filter.findAll": "In allem suchen",
  "list.failed": "Die Liste konnte nicht gelesen werden: {reason}. Neuer Versuch läuft.",
  "list.since": "Von",
  "list.until": "Bis",
  "pages.label": "Seiten",
  "pages.before": "Zurück",
  "pages.next": "Weitere",
};
