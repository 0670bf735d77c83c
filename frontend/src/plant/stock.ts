/** What a buffer's level means. */
import type { BufferView } from "../api/types";

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
