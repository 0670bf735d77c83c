/**
 * What is to be seen of the machines. They say the same every second: only what looks otherwise than
 * before is worth a new picture of all of them.
 */
import type { BufferView, MachineView } from "../../api/types";

export interface MachineLook {
  /** Undefined for a machine that was never heard. */
  readonly view: MachineView | undefined;
  /** Silent: what it said last is a memory. */
  readonly lost: boolean;
}

export type MachineLooks = ReadonlyMap<string, MachineLook>;

export function machineLooks(
  ids: Iterable<string>,
  views: ReadonlyMap<string, MachineView>,
  isLost: (view: MachineView) => boolean,
): MachineLooks {
  const looks = new Map<string, MachineLook>();
  for (const id of ids) {
    const view = views.get(id);
    looks.set(id, { view, lost: view !== undefined && isLost(view) });
  }
  return looks;
}

/** Whether a picture of one is a picture of the other. */
export function lookAlike(some: MachineLooks, others: MachineLooks): boolean {
  if (some.size !== others.size) return false;
  for (const [id, look] of some) {
    const other = others.get(id);
    if (look.lost !== other?.lost || !isSameSight(look.view, other.view)) return false;
  }
  return true;
}

function isSameSight(a: MachineView | undefined, b: MachineView | undefined): boolean {
  if (a === b) return true;
  if (!a || !b) return false;
  return (
    a.status === b.status &&
    a.product === b.product &&
    areSameStocks(a.buffers, b.buffers) &&
    areSameStocks(a.goods, b.goods)
  );
}

function areSameStocks(some: readonly BufferView[], others: readonly BufferView[]): boolean {
  return some.length === others.length && some.every((one, i) => isSameStock(one, others[i]));
}

function isSameStock(a: BufferView, b: BufferView | undefined): boolean {
  return (
    a.item === b?.item &&
    a.level === b.level &&
    a.capacity === b.capacity &&
    a.reorder_point === b.reorder_point &&
    a.on_order === b.on_order
  );
}
