/** Why a transport that was called for waits, and why the vehicle that is to carry it does not come, in German. */
import type { Catalogue } from "../../catalogue";
import type { waits as en } from "./en";

export const waits: Catalogue<typeof en> = {
  "calling.wait.no_room": "dort ist noch kein Platz dafür",
  "calling.wait.short": "es ist noch nicht genug davon da",
  "calling.wait.no_bid": "noch kann kein Fahrzeug",
  "calling.wait.not_before": "es soll noch nicht beginnen",
  "calling.wait.undecided": "es wird angeboten",
  "calling.shortage.free": "Frei in {place}: {free}.",
  "calling.shortage.coming": "Dorthin bestellt: {quantity}.",
  "calling.shortage.elsewhere": "Genug davon ist in {places}.",
  "unwilling.gone": "es ist nicht mehr da",
  "unwilling.silent": "nichts ist von ihm zu hören",
  "unwilling.shut_out": "es ist ausgeschlossen",
  "unwilling.carried_away": "es wurde weggetragen",
  "unwilling.out_of_service": "es ist außer Betrieb",
  "unwilling.error": "es hat eine Störung",
  "unwilling.stopped": "es ist angehalten",
  "unwilling.busy": "es ist an der Arbeit",
  "unwilling.battery": "seine Batterie ist zu leer",
  "unwilling.charging": "es wurde zum Laden geschickt",
  "unwilling.ability": "es kann das nicht tragen",
  "unwilling.no_way": "es findet keinen Weg",
  "unwilling.closed": "was gesperrt ist, lässt ihm keinen Weg",
  "unwilling.deadline": "es könnte nicht rechtzeitig da sein",
  "unwilling.not_fit": "es nimmt zurzeit keine Arbeit",
  "unwilling.watching_enough": "es wacht schon über genug andere",
  "unwilling.is_primary": "es bringt es schon",
};
