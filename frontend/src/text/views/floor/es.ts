/** What is said of things that lie on lanes and of doors that do not open, which is loaded where there are any, in Spanish. */
import type { Catalogue } from "../../catalogue";
import type { floor as en } from "./en";

export const floor: Catalogue<typeof en> = {
  "obstacles.title": "En el camino",
  "obstacles.seen": "{atv} lo encontró a las {at}. Los vehículos lo rodean; desde las {until} alguien vuelve a mirar.",
  "obstacles.cleared": "Ya no está",
  "obstacles.clearedOf": "Ya no está: {where}",
  "obstacles.door": "{door} no se abre",
  "obstacles.doorSeen": "{where}: {atv} estaba delante a las {at}. Los vehículos la rodean; desde las {until} alguien vuelve a mirar.",
  "obstacles.doorCleared": "Se abre",
  "obstacles.doorClearedOf": "Se abre: {door}, {where}",
};
