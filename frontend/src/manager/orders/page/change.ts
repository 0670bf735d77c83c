/** An order that is being changed: what is written, and what of it is sent. Pure. */
import type { OrderChange } from "../../../api/client";
import type { OrderView } from "../../../api/types";
import type { Priority } from "../priority";

export interface Written {
  readonly quantities: readonly string[];
  /** As a datetime-local field has it: local time without a zone. */
  readonly due: string;
  readonly priority: Priority;
  readonly reference: string;
}

type Item = OrderView["items"][number];

export function writtenOf(order: OrderView): Written {
  return {
    quantities: order.items.map((item) => String(wantedOf(item))),
    due: order.due_at_s === null ? "" : localOf(order.due_at_s),
    priority: order.priority,
    reference: order.reference ?? "",
  };
}

/** As few pieces as are still possible: what is made is kept. */
export function leastOf(item: Item): number {
  return Math.max(1, item.made, item.delivered);
}

function wantedOf(item: Item): number {
  return item.wanted ?? item.quantity;
}

/** What is to change; null for nothing, "wrong" where a quantity is none that is possible. */
export function changeOf(order: OrderView, written: Written): OrderChange | "wrong" | null {
  const before = writtenOf(order);
  const change: OrderChange = {};
  if (written.quantities.some((each, index) => each !== before.quantities[index])) {
    const quantities = written.quantities.map((each) => (/^\d{1,5}$/.test(each.trim()) ? Number(each) : 0));
    if (order.items.some((item, index) => (quantities[index] ?? 0) < leastOf(item))) return "wrong";
    change.quantities = quantities;
  }
  if (written.due !== before.due) {
    if (written.due !== "" && Number.isNaN(Date.parse(written.due))) return "wrong";
    change.due_at = written.due === "" ? null : new Date(written.due).toISOString();
  }
  if (written.priority !== before.priority) change.priority = written.priority;
  if (written.reference.trim() !== before.reference) change.reference = written.reference.trim() || null;
  return Object.keys(change).length === 0 ? null : change;
}

function localOf(atS: number): string {
  const at = new Date(atS * 1000);
  return new Date(at.getTime() - at.getTimezoneOffset() * 60_000).toISOString().slice(0, 16);
}
