/** Whom an alert is about, in people's words, and the way there. */
import { chosenOf } from "../../alerts/alerts";
import type { AlertView } from "../../api/types";
import { choose } from "../../selection/selection";
import { world } from "../../stream/stream";
import { go } from "../views";

export function subjectOf({ agent, order, task }: AlertView): string {
  if (order !== "") return world.value?.orders.get(order)?.reference ?? order;
  return task === "" ? agent : task;
}

export function showSubject(alert: AlertView): void {
  const chosen = chosenOf(alert);
  if (chosen) choose(chosen);
  go(chosen ? "plant" : "orders");
}
