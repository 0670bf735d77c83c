/** Whom an alert is about, in people's words, and the way there. */
import { chosenOf, isOfPlant } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { choose } from "../../selection/selection";
import { world } from "../../stream/stream";
import { t } from "../../text";
import { go } from "../views";

export function subjectOf(alert: AlertView): string {
  const { agent, order, task } = alert;
  if (isOfPlant(alert)) return t("alerts.plant");
  if (order !== "") return world.value?.orders.get(order)?.reference ?? order;
  return task === "" ? agent : task;
}

export function showSubject(alert: AlertView): void {
  const chosen = chosenOf(alert, world.value?.atvs ?? new Map());
  if (chosen) choose(chosen);
  go(chosen || isOfPlant(alert) ? "plant" : "orders");
}
