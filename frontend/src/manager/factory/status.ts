/** How many are in which status; who is silent is in none: what it said last is a memory. Pure. */
import { isLost } from "../../plant/silence";

/** The word for those who are not heard any more, beside the statuses that agents tell. */
export const LOST = "lost";

interface Seen {
  readonly status: string;
  readonly seen_at_s: number;
  readonly task?: unknown;
}

export function statusCounts(views: Iterable<Seen>, nowS: number, speed: number): Record<string, number> {
  const counts: Record<string, number> = {};
  for (const view of views) {
    const status = isLost(view, nowS, speed) ? LOST : view.status;
    counts[status] = (counts[status] ?? 0) + 1;
  }
  return counts;
}
