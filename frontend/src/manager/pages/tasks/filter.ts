/** Which tasks are wanted. Pure. */
import type { TaskView } from "../../../api/types";
import { isOpen } from "../../cards/auction/auction";
import { holds } from "../../parts/filters/match";
import type { Names } from "../../../plant/names";

export const STATES = ["bidding", "contracted", "delivered", "withdrawn"] as const;

export interface Wanted {
  readonly words: string;
  /** Empty for any. */
  readonly state: string;
  readonly item: string;
  readonly late: boolean;
}

export function isWanted(task: TaskView, wanted: Wanted, nowS: number, names: Names): boolean {
  if (wanted.state !== "" && task.state !== wanted.state) return false;
  if (wanted.item !== "" && task.item !== wanted.item) return false;
  if (wanted.late && !isLate(task, nowS)) return false;
  return holds(wanted.words, task.id, task.coordinator, task.primary, task.secondary, task.destination, names(task.item));
}

/** Delivered after its promise, or still not there although that has passed. */
export function isLate(task: TaskView, nowS: number): boolean {
  if (task.promised_at_s === null || task.state === "withdrawn") return false;
  return (isOpen(task) ? nowS : (task.closed_at_s ?? nowS)) > task.promised_at_s;
}
