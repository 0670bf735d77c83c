/** How soon an order is wanted. */
import type { OrderView } from "../../api/types";

export type Priority = OrderView["priority"];

/** The most urgent first. */
export const PRIORITIES = ["urgent", "high", "normal", "low"] as const satisfies readonly Priority[];

export function isPriority(word: string): word is Priority {
  return PRIORITIES.some((each) => each === word);
}
