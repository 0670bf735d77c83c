/** Deeds on several orders: one request each, so that each has its line in the audit log and its own answer. */
import { signal } from "@preact/signals";
import { cancelOrder, releaseOrder, revokeOrder } from "../../../api/client";
import type { OrderView } from "../../../api/types";
import { problemText } from "../../problem-text";
import { canBeTakenBack, isClosed } from "../progress";

export type Deed = "release" | "revoke" | "cancel";

const RUN: Readonly<Record<Deed, (order: string) => Promise<void>>> = {
  release: releaseOrder,
  revoke: revokeOrder,
  cancel: cancelOrder,
};

/** As many at once as leave a gateway time for others. */
const AT_ONCE = 4;

/** Ids of those whose box is ticked. */
export const ticked = signal<ReadonlySet<string>>(new Set());
/** With which orders it did not work, and why: told also when their rows are in the list no more. */
export const refused = signal<readonly { readonly order: OrderView; readonly reason: string }[]>([]);
/** How many are done of how many; null when nothing runs. */
export const running = signal<{ readonly done: number; readonly of: number } | null>(null);

/** Raised when the list is left: what a deed says that runs still is for nobody then. */
let visit = 0;

/** When the list is left. */
export function forget(): void {
  visit += 1;
  ticked.value = new Set();
  refused.value = [];
}

export function tick(order: string, on: boolean): void {
  const after = new Set(ticked.value);
  if (on) after.add(order);
  else after.delete(order);
  ticked.value = after;
}

/** Whether this can be done to an order as it is. */
export function isPossible(deed: Deed, order: OrderView): boolean {
  switch (deed) {
    case "release":
      return order.status === "stored";
    case "revoke":
      return canBeTakenBack(order);
    case "cancel":
      return !isClosed(order);
  }
}

export async function doAll(deed: Deed, orders: readonly OrderView[]): Promise<void> {
  const left = [...orders];
  const failed: { order: OrderView; reason: string }[] = [];
  const from = visit;
  refused.value = [];
  running.value = { done: 0, of: orders.length };
  const work = async (): Promise<void> => {
    for (let order = left.shift(); order !== undefined; order = left.shift()) {
      try {
        await RUN[deed](order.id);
        tick(order.id, false);
      } catch (error) {
        failed.push({ order, reason: problemText(error) });
      }
      running.value = { done: (running.value?.done ?? 0) + 1, of: orders.length };
    }
  };
  await Promise.all(Array.from({ length: AT_ONCE }, work));
  if (from === visit) refused.value = failed;
  running.value = null;
}
