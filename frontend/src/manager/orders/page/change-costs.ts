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
  const products = new Set(order.items.map((item) => item.product));
  return [...orders]
    .filter((each) => each.id !== order.id && !isClosed(each) && each.wanted_at_s !== null && each.items.some((item) => products.has(item.product)))
    .filter(({ wanted_at_s }) => wanted_at_s !== null && wanted_at_s > afterS && wanted_at_s <= beforeS)
    .sort((a, b) => (a.wanted_at_s ?? 0) - (b.wanted_at_s ?? 0));
}
