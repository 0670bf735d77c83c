/** How the estimate of an order has moved: its band in time, and the moves that have a number. Pure. */
import type { components } from "../../../api/types";
import type { Span } from "./lanes";

export type Estimate = components["schemas"]["EstimateView"];

/** One estimate as long as it was told; in percent of the drawing, the later up. */
export interface Step {
  readonly leftPercent: number;
  readonly widthPercent: number;
  readonly topPercent: number;
  readonly heightPercent: number;
}

/** A move that people want to know the cause of. */
export interface Move {
  readonly estimate: Estimate;
  /** By how many seconds it ends later; negative for sooner, null where one of both could not be told. */
  readonly byS: number | null;
}

/** Of the height, above and below all that is drawn. */
const ROOM_FRAC = 0.08;

const LEAST_SPAN_S = 60;
const LEAST_ENDED_S = 5;

/** Of the drawing's height, what a time beside it takes. */
const LABEL_PERCENT = 13;

/** From the first estimate to now, or to the order's end. */
export function timeOf(estimates: readonly Estimate[], untilS: number, hasEnded: boolean): Span {
  const fromS = estimates[0]?.at_s ?? untilS;
  return { fromS, toS: Math.max(untilS, estimates.at(-1)?.at_s ?? untilS, fromS + (hasEnded ? LEAST_ENDED_S : LEAST_SPAN_S)) };
}

/** When it is due, as far as the drawing shows that: of what has ended, only where that was ever expected later. */
export function dueOnBand(estimates: readonly Estimate[], dueS: number | null, deliveredS: number | null, hasEnded: boolean): number | null {
  const latestS = Math.max(deliveredS ?? -Infinity, ...estimates.map(({ to_at_s: toS }) => toS ?? -Infinity));
  return hasEnded && dueS !== null && dueS > latestS ? null : dueS;
}

/** From the earliest to the latest that was ever expected, with what is due and when it was delivered. */
export function heightOf(estimates: readonly Estimate[], marks: readonly (number | null)[]): Span {
  const all = [...estimates.flatMap(({ from_at_s, to_at_s }) => [from_at_s, to_at_s]), ...marks].filter((atS) => atS !== null);
  const fromS = Math.min(...all);
  const toS = Math.max(fromS + LEAST_SPAN_S, ...all);
  const roomS = (toS - fromS) * ROOM_FRAC;
  return { fromS: fromS - roomS, toS: toS + roomS };
}

/** Where the times beside the drawing stand, so that the later one, which is above, does not cover the earlier one. */
export function labelsOf(ends: readonly number[], height: Span): { readonly atS: number; readonly topPercent: number }[] {
  const [low, high] = [topOf(height, Math.min(...ends)), topOf(height, Math.max(...ends))];
  const byPercent = Math.max(0, LABEL_PERCENT - (low - high)) / 2;
  return [...new Set(ends)].map((atS, _index, all) => ({
    atS,
    topPercent: topOf(height, atS) + (all.length < 2 ? 0 : atS === Math.max(...ends) ? -byPercent : byPercent),
  }));
}

export function leftOf(span: Span, atS: number): number {
  return ((atS - span.fromS) / (span.toS - span.fromS)) * 100;
}

export function topOf(span: Span, atS: number): number {
  return 100 - leftOf(span, atS);
}

/** What was told, and for how long; a gap where nothing could be. */
export function stepsOf(estimates: readonly Estimate[], time: Span, height: Span, untilS: number): Step[] {
  return estimates.flatMap(({ at_s: atS, from_at_s: fromS, to_at_s: toS }, index) => {
    if (fromS === null || toS === null) return [];
    const leftPercent = leftOf(time, atS);
    const endPercent = leftOf(time, estimates[index + 1]?.at_s ?? Math.max(untilS, atS));
    const topPercent = topOf(height, toS);
    return [{ leftPercent, widthPercent: endPercent - leftPercent, topPercent, heightPercent: topOf(height, fromS) - topPercent }];
  });
}

/** All but the first estimate and those that only say the same more exactly, oldest first. */
export function movesOf(estimates: readonly Estimate[]): Move[] {
  return estimates.flatMap((estimate, index) => {
    if (estimate.cause === "first" || estimate.cause === "closer") return [];
    const before = estimates[index - 1]?.to_at_s ?? null;
    return [{ estimate, byS: before === null || estimate.to_at_s === null ? null : estimate.to_at_s - before }];
  });
}

/** Of the drawing's width, what a number of two digits takes on the narrowest screen. */
const NUMBER_PERCENT = 8;

/** Lines of numbers above the drawing. A number that has no room on any of them is not drawn: the list below has it. */
const LINES_MOST = 3;

/**
 * On which line above the drawing each number stands, 0 for the lowest, so that none covers another; null where there is no room.
 *
 * @param leftPercents where they stand, from left to right
 */
export function linesOf(leftPercents: readonly number[]): (number | null)[] {
  const last: number[] = [];
  return leftPercents.map((left) => {
    const free = last.findIndex((before) => left - before >= NUMBER_PERCENT);
    const line = free >= 0 ? free : last.length;
    if (line >= LINES_MOST) return null;
    last[line] = left;
    return line;
  });
}
