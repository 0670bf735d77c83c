/** Whom an alert is about, in people's words, and the way there. */
import { chosenOf, isOfPlant } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { GATE } from "../../plant/places";
import { choose } from "../../selection/selection";
import { world } from "../../stream/stream";
import { t } from "../../text";
import { orderName, taskName } from "../state";
import { addressOf, addressOfTransport, go, storyOf, transportOf } from "../views";

/** The order by whose name an alert is told; empty where it is told by another one: goods by the vehicle that has them on board. */
export function orderOf({ agent, goods, order }: AlertView): string {
  return goods !== null && agent !== "" ? "" : order;
}

export function subjectOf(alert: AlertView): string {
  const { agent, goods, task } = alert;
  if (isOfPlant(alert)) return t("alerts.plant");
  if (goods !== null && agent !== "") return agent;
  const order = orderOf(alert);
  if (order !== "") return orderName(order);
  if (task === "") return agent === GATE ? t("gate.title") : agent;
  return taskName(task, world.value?.tasks.get(task)?.order ?? "");
}

/** The page of the order or transport by whose name an alert is told; empty where it is told by another one. */
export function pageOf(alert: AlertView): string {
  const order = orderOf(alert);
  if (order !== "") return addressOf(order);
  if (alert.goods !== null || alert.task === "") return "";
  const task = world.value?.tasks.get(alert.task);
  if (task) return storyOf(task);
  const transport = transportOf(alert.task);
  return transport === "" ? "" : addressOfTransport(transport);
}

export function showSubject(alert: AlertView): void {
  const page = pageOf(alert);
  if (page !== "") {
    location.hash = page;
    return;
  }
  const chosen = chosenOf(alert, world.value?.atvs ?? new Map());
  if (chosen) choose(chosen);
  go("plant");
}
