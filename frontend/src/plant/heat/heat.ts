/** What happened on each lane in a period, in few steps that the eye can tell apart. Pure. */
import type { Lane, LaneTraffic } from "../../api/types";

/** How often a lane was passed, how often vehicles came to a stand there, and for how long (s). */
export const MEASURES = ["passes", "waits", "waited_s"] as const;
export type Measure = (typeof MEASURES)[number];

export interface Heat {
  readonly measure: Measure;
  /** Of the lane as it is drawn: both directions together. */
  readonly of: (lane: Lane) => number;
  /** The lowest figure of each step, the calmest first; empty where nothing happened. */
  readonly steps: readonly number[];
}

/** More shades of one colour than these cannot be told apart. */
const STEPS = 5;

export function heatOf(items: readonly LaneTraffic[], measure: Measure): Heat {
  const figures = new Map<string, number>();
  for (const lane of items) {
    const key = keyOf(lane.start, lane.end);
    figures.set(key, (figures.get(key) ?? 0) + lane[measure]);
  }
  return {
    measure,
    of: ({ end, start }) => figures.get(keyOf(start, end)) ?? 0,
    steps: stepsTo(Math.floor(Math.max(0, ...figures.values()))),
  };
}

/** Even steps up to the busiest lane, by whole figures: the lowest is 1, and no two are alike. */
export function stepsTo(most: number): number[] {
  const count = Math.min(STEPS, most);
  return Array.from({ length: count }, (_, step) => 1 + Math.floor((step * most) / count));
}

/** @returns which step is reached, from 1 on; 0 for none */
export function stepOf(figure: number, steps: readonly number[]): number {
  return steps.filter((from) => figure >= from).length;
}

function keyOf(a: string, b: string): string {
  return a < b ? `${a} ${b}` : `${b} ${a}`;
}
