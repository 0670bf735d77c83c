/** What a buffer's level means. */
import type { BufferView, MachineSpec, MachineView, Product } from "../api/types";

/**
 * Whether a person should look: empty, or at the reorder point with nothing on the way. To be below
 * the reorder point with a delivery on order is how replenishment is meant to work.
 */
export function isLow(buffer: Pick<BufferView, "level" | "reorder_point" | "on_order">): boolean {
  if (buffer.level <= 0) return true;
  return buffer.level <= buffer.reorder_point && buffer.on_order === 0;
}

export function filledFrac(buffer: Pick<BufferView, "level" | "capacity">): number {
  if (buffer.capacity <= 0) return 0;
  return Math.min(1, Math.max(0, buffer.level / buffer.capacity));
}

/**
 * How long a material lasts at least, in plant seconds, if the machine works without a pause: through its goals in their order, until one piece lacks some.
 * The piece in the making has its material already; what is left of its cycle, which nobody tells, comes on top. Goals that are offered to others do not count.
 * Null where it lasts for all of them, and where the machine does not work.
 */
export function lastsS(
  machine: Pick<MachineView, "goals" | "speed_frac" | "status" | "buffers">,
  spec: Pick<MachineSpec, "makes">,
  products: readonly Pick<Product, "id" | "bill">[],
  item: string,
): number | null {
  if (machine.status === "error") return null;
  let level = machine.buffers.find((buffer) => buffer.item === item)?.level ?? 0;
  let spanS = 0;
  for (const { offered, product, to_begin: left } of machine.goals) {
    if (offered) continue;
    const cycleS = spec.makes.find((making) => making.product === product)?.cycle_s;
    if (cycleS === undefined) return null; // A product that the plant file does not know.
    const each = products.find(({ id }) => id === product)?.bill.find(({ material }) => material === item)?.quantity ?? 0;
    const possible = each === 0 ? left : Math.floor(level / each);
    if (possible < left) return spanS + (possible * cycleS) / machine.speed_frac;
    spanS += (left * cycleS) / machine.speed_frac;
    level -= left * each;
  }
  return null;
}
