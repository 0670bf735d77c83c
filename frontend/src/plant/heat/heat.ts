/** How often each lane was passed lately, in few steps that the eye can tell apart. Pure. */
import type { Lane } from "../../api/types";

export interface LanePasses {
  readonly start: string;
  readonly end: string;
  readonly passes: number;
}

export interface Heat {
  /** Of the lane as it is drawn: both directions together. */
  readonly of: (lane: Lane) => number;
  /** The lowest number of passes of each step, the calmest first; empty where nothing was passed. */
  readonly steps: readonly number[];
}

/** More shades of one colour than these cannot be told apart. */
const STEPS = 5;

export function heatOf(items: readonly LanePasses[]): Heat {
  const passes = new Map<string, number>();
  for (const { end, passes: more, start } of items) {
    const key = keyOf(start, end);
    passes.set(key, (passes.get(key) ?? 0) + more);
  }
  return {
    of: ({ end, start }) => passes.get(keyOf(start, end)) ?? 0,
    steps: stepsTo(Math.max(0, ...passes.values())),
  };
}

/** Even steps up to the busiest lane, by whole passes: the lowest is 1, and no two are alike. */
export function stepsTo(most: number): number[] {
  const count = Math.min(STEPS, most);
  return Array.from({ length: count }, (_, step) => 1 + Math.floor((step * most) / count));
}

/** @returns which step is reached, from 1 on; 0 for none */
export function stepOf(passes: number, steps: readonly number[]): number {
  return steps.filter((from) => passes >= from).length;
}

function keyOf(a: string, b: string): string {
  return a < b ? `${a} ${b}` : `${b} ${a}`;
}
