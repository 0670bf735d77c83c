/** Alerts in the order in which they are answered, and what to show for them. Pure. */
import type { AlertView } from "../api/types";
import type { Chosen } from "../selection/selection";

/** Nobody has taken it on yet. */
export function isOpen(alert: AlertView): boolean {
  return alert.acknowledged_by === "";
}

export interface AlertCounts {
  readonly alarms: number;
  readonly alarmsTaken: number;
  readonly warnings: number;
  readonly warningsTaken: number;
}

/** How many there are that nobody has taken on, and that somebody has. */
export function countsOf(alerts: readonly AlertView[]): AlertCounts {
  const count = (level: AlertView["level"], open: boolean): number =>
    alerts.filter((alert) => alert.level === level && isOpen(alert) === open).length;
  return {
    alarms: count("alarm", true),
    alarmsTaken: count("alarm", false),
    warnings: count("warning", true),
    warningsTaken: count("warning", false),
  };
}

/** What nobody has taken on comes first, alarms before warnings, and the newest on top. */
export function inOrder(alerts: Iterable<AlertView>): AlertView[] {
  return [...alerts].sort(
    (a, b) =>
      Number(isOpen(b)) - Number(isOpen(a)) ||
      Number(b.level === "alarm") - Number(a.level === "alarm") ||
      b.since_at_s - a.since_at_s ||
      a.id.localeCompare(b.id),
  );
}

/** It is about the plant as a whole. */
export function isOfPlant({ agent, order, task }: AlertView): boolean {
  return agent === "" && order === "" && task === "";
}

/**
 * What on the plant it is about; null for an order, and for the plant as a whole.
 *
 * @param atvs the vehicles that are heard: a clock may be wrong, and a word disbelieved, of a vehicle or of what stands still
 */
export function chosenOf({ agent, kind, task }: AlertView, atvs: ReadonlyMap<string, unknown>): Chosen | null {
  if (task !== "") return { kind: "task", id: task };
  if (agent === "") return null;
  return { kind: kind.startsWith("atv_") || atvs.has(agent) ? "atv" : "machine", id: agent };
}
