/** How far an order is, over all its items. */
import type { OrderView } from "../../api/types";

export interface Progress {
  readonly quantity: number;
  readonly made: number;
  readonly delivered: number;
}

export function progressOf(order: OrderView): Progress {
  return order.items.reduce(
    (sum, item) => ({
      quantity: sum.quantity + item.quantity,
      made: sum.made + item.made,
      delivered: sum.delivered + item.delivered,
    }),
    { quantity: 0, made: 0, delivered: 0 },
  );
}

/** How an order stands, as a word of the catalogue's group `order`. */
export function stateOf(order: OrderView): string {
  if (order.status === "stored") return order.releases > 0 ? "taken_back" : "stored";
  if (order.revoked_at_s !== null && !isClosed(order)) return "being_taken_back";
  return order.status === "in_production" && !order.begun ? "planned" : order.status;
}

/** Whether the factory works at it, and nobody has asked it to stop. */
export function canBeTakenBack(order: OrderView): boolean {
  return order.status !== "stored" && order.revoked_at_s === null && !isClosed(order);
}

export function isClosed(order: OrderView): boolean {
  return order.status === "delivered" || order.status === "cancelled";
}

/** Open ones as the factory wants them, those without a time after them; then the closed, the newest first. */
export function inOrder(orders: Iterable<OrderView>): OrderView[] {
  return [...orders].sort((a, b) => {
    const closed = Number(isClosed(a)) - Number(isClosed(b));
    if (closed !== 0) return closed;
    if (isClosed(a)) return (b.delivered_at_s ?? b.created_at_s) - (a.delivered_at_s ?? a.created_at_s);
    return (a.wanted_at_s ?? a.due_at_s ?? Infinity) - (b.wanted_at_s ?? b.due_at_s ?? Infinity) || a.created_at_s - b.created_at_s || 0;
  });
}

/** Due and not delivered. */
export function isLate(order: OrderView, nowS: number): boolean {
  if (order.due_at_s === null || order.status === "cancelled") return false;
  return (order.delivered_at_s ?? nowS) > order.due_at_s;
}
