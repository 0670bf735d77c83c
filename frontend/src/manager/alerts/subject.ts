/** Whom an alert is about, in people's words, and the way there. */
import { chosenOf, isOfPlant } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { choose } from "../../selection/selection";
import { world } from "../../stream/stream";
import { t } from "../../text";
import { orderName, taskName } from "../state";
import { go } from "../views";

export function subjectOf(alert: AlertView): string {
  const { agent, goods, order, task } = alert;
  if (isOfPlant(alert)) return t("alerts.plant");
  if (goods !== null && agent !== "") return agent;
  if (order !== "") return orderName(order);
  return task === "" ? agent : taskName(task, world.value?.tasks.get(task)?.order ?? "");
}

export function showSubject(alert: AlertView): void {
  const chosen = chosenOf(alert, world.value?.atvs ?? new Map());
  if (chosen) choose(chosen);
  go(chosen || isOfPlant(alert) ? "plant" : "orders");
}
