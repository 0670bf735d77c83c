/** How many are in which status; who is silent is in none: what it said last is a memory. Pure. */
import { isLost } from "../../plant/silence";

/** The word for those who are not heard any more, beside the statuses that agents tell. */
export const LOST = "lost";
/** And for those that nobody is to hear. */
export const SHUT_OUT = "shut_out";

interface Seen {
  readonly status: string;
  readonly seen_at_s: number;
  readonly task?: unknown;
  readonly shut_out?: unknown;
}

export function statusCounts(views: Iterable<Seen>, nowS: number, speed: number): Record<string, number> {
  const counts: Record<string, number> = {};
  for (const view of views) {
    const silent = view.shut_out ? SHUT_OUT : LOST;
    const status = isLost(view, nowS, speed) ? silent : view.status;
    counts[status] = (counts[status] ?? 0) + 1;
  }
  return counts;
}
