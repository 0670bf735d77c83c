/** What is said of things that lie on lanes and of doors that do not open, which is loaded where there are any, in German. */
import type { Catalogue } from "../../catalogue";
import type { floor as en } from "./en";

export const floor: Catalogue<typeof en> = {
  "obstacles.title": "Im Weg",
  "obstacles.seen": "{atv} stieß um {at} darauf. Fahrzeuge fahren außen herum; ab {until} sieht wieder jemand nach.",
  "obstacles.cleared": "Ist weg",
  "obstacles.clearedOf": "Ist weg: {where}",
  "obstacles.door": "{door} geht nicht auf",
  "obstacles.doorSeen": "{where}: {atv} stand um {at} davor. Fahrzeuge fahren außen herum; ab {until} sieht wieder jemand nach.",
  "obstacles.doorCleared": "Geht auf",
  "obstacles.doorClearedOf": "Geht auf: {door}, {where}",
};
