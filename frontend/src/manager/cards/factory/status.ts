/** How many are in which status; who is silent is in none: what it said last is a memory. Pure. */
import { isLost, type Seen } from "../../../plant/silence";

/** The word for those who are not heard any more, beside the statuses that agents tell. */
export const LOST = "lost";
/** And for those that nobody is to hear. */
export const SHUT_OUT = "shut_out";

export function statusCounts(views: Iterable<Seen & { readonly status: string }>, nowS: number, speed: number): Record<string, number> {
  const counts: Record<string, number> = {};
  for (const view of views) {
    const silent = view.shut_out ? SHUT_OUT : LOST;
    const status = isLost(view, nowS, speed) ? silent : view.status;
    counts[status] = (counts[status] ?? 0) + 1;
  }
  return counts;
}
