/**
 * When silence of one agent means that what is shown of it is a memory. As the agents themselves judge:
 * three beats and a half second.
 */

/** Who carries something speaks every second of factory time, everybody else every five. */
const WORKING_BEAT_S = 1;
const IDLE_BEAT_S = 5;
const BEATS = 3;
const SLACK_S = 0.5;
/** However fast the factory runs: browsers are told ten times a second at most, and a page may be busy. */
const LEAST_S = 2;
const LEAST_OVERDUE_S = 1.2;

interface Seen {
  readonly seen_at_s: number;
  /** Of a vehicle: what it carries out. */
  readonly task?: unknown;
  /** Nobody hears it any more, by a manager's word. */
  readonly shut_out?: unknown;
}

/** Whoever is shut out is silent at once. @param speed factory seconds per real second */
export function isLost(view: Seen, nowS: number, speed: number): boolean {
  return Boolean(view.shut_out) || nowS - view.seen_at_s > boundS(view, speed);
}

/** The silence of this one that counts as failure, in real seconds. */
export function boundS(view: Pick<Seen, "task">, speed: number): number {
  return Math.max(LEAST_S, (BEATS * beatS(view) + SLACK_S) / Math.max(speed, 0.1));
}

/** Whether a heartbeat should have come by now: nothing to act on, but something to look at. */
export function isOverdue(view: Seen, nowS: number, speed: number): boolean {
  return nowS - view.seen_at_s > Math.max(LEAST_OVERDUE_S, (beatS(view) + SLACK_S) / Math.max(speed, 0.1));
}

function beatS(view: Pick<Seen, "task">): number {
  return view.task ? WORKING_BEAT_S : IDLE_BEAT_S;
}
