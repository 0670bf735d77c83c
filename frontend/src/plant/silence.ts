/**
 * When silence of one agent means that what is shown of it is a memory. The rule is that of the agents, and the gateway tells
 * with every view what it gives; there is no figure of it here.
 */
import type { AtvView } from "../api/types";

/** A vehicle, a machine or a station. */
export type Seen = Pick<AtvView, "seen_at_s" | "shut_out" | "silence">;

/** Whoever is shut out, by a manager's word, is silent at once. @param speed factory seconds per real second */
export function isLost(view: Seen, nowS: number, speed: number): boolean {
  return view.shut_out !== null || nowS - view.seen_at_s > boundS(view, speed);
}

/** The silence of this one that counts as failure, in real seconds. */
export function boundS({ silence }: Pick<Seen, "silence">, speed: number): number {
  return silence.lost_after_s / speed;
}

/** Whether a heartbeat should have come by now: nothing to act on, but something to look at. */
export function isOverdue({ seen_at_s, silence }: Pick<Seen, "seen_at_s" | "silence">, nowS: number, speed: number): boolean {
  return nowS - seen_at_s > silence.overdue_after_s / speed;
}
