/** What a change costs others: the orders that would be wanted after it and are wanted before it now. Pure. */
import type { OrderChange } from "../../../api/client";
import type { OrderView } from "../../../api/types";
import { isClosed } from "../progress";

/** Seconds of the plant's clock after its release within which an order is wanted at the latest. */
const WITHIN_S = { urgent: 900, high: 2700 } as const;

/** Orders for the same products that a change lets wait, those wanted first before the others. */
export function passedBy(order: OrderView, change: OrderChange, orders: Iterable<OrderView>, speed: number): OrderView[] {
  const beforeS = order.wanted_at_s ?? Infinity;
  const dueS = change.due_at === undefined ? order.due_at_s : change.due_at === null ? null : Date.parse(change.due_at) / 1000;
  const priority = change.priority ?? order.priority;
  const usualS = dueS ?? beforeS;
  const afterS = priority === "urgent" || priority === "high" ? Math.min(usualS, order.created_at_s + WITHIN_S[priority] / speed) : usualS;
  return between(order, afterS, beforeS, orders);
}

export interface Move {
  /** It goes before these. */
  readonly passes: readonly OrderView[];
  /** These go before it. */
  readonly letsPass: readonly OrderView[];
}

/** Who changes places for the same products, where an order of the queue is put before another one. */
export function moved(order: OrderView, before: OrderView, queue: readonly OrderView[]): Move {
  const [from, to] = [queue.indexOf(order), queue.indexOf(before)];
  const sharing = (orders: readonly OrderView[]): OrderView[] => orders.filter((each) => shares(order, each));
  return { passes: sharing(queue.slice(to, from)), letsPass: sharing(queue.slice(from + 1, to)) };
}

/** Open orders for the same products that are wanted after one moment, and at another at the latest. */
function between(order: OrderView, afterS: number, untilS: number, orders: Iterable<OrderView>): OrderView[] {
  return [...orders]
    .filter((each) => each.id !== order.id && !isClosed(each) && shares(order, each))
    .filter(({ wanted_at_s }) => wanted_at_s !== null && wanted_at_s > afterS && wanted_at_s <= untilS)
    .sort((a, b) => (a.wanted_at_s ?? 0) - (b.wanted_at_s ?? 0));
}

function shares(order: OrderView, other: OrderView): boolean {
  return other.items.some(({ product }) => order.items.some((item) => item.product === product));
}
