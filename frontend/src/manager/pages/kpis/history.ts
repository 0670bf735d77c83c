/** The factory's figures over time, as charts need them. Pure. */
import type { KpiHistory, KpiPoint } from "../../../api/types";

/** How far one looks back, and in which steps: 60 to 170 points each. */
export const RANGES = {
  hour: { spanS: 3600, stepS: 60 },
  shift: { spanS: 8 * 3600, stepS: 300 },
  week: { spanS: 7 * 86_400, stepS: 3600 },
} as const;
export type Range = keyof typeof RANGES;

/** Figures that are numbers or nobody knows. */
export type Figure = Exclude<keyof KpiPoint, "at_s">;
export type Column = readonly (number | null)[];

/** When the steps begin, all of them: where nothing was seen a chart has a gap. */
export function stepsOf({ since_at_s, step_s, until_at_s }: KpiHistory): number[] {
  const count = Math.round((until_at_s - since_at_s) / step_s);
  return Array.from({ length: Math.max(0, count) }, (_, i) => since_at_s + i * step_s);
}

/** One figure, step by step. */
export function columnOf(history: KpiHistory, figure: Figure): Column {
  const seen = new Map(history.items.map((point) => [point.at_s, point[figure]]));
  return stepsOf(history).map((atS) => seen.get(atS) ?? null);
}

/** Each column on top of those before it; a gap in one is a gap in all. */
export function stacked(columns: readonly Column[]): Column[] {
  const sums: (number | null)[] = [];
  return columns.map((column) =>
    column.map((value, i) => {
      const below = sums[i] === undefined ? 0 : sums[i];
      const sum = value === null || below === null ? null : below + value;
      sums[i] = sum;
      return sum;
    }),
  );
}

/** The steps whose figure has none beside it: no line leads there, so they are drawn as dots. @param spans whether lines lead over gaps */
export function aloneIn(column: Column, spans = false): number[] {
  const known = column.flatMap((value, i) => (value === null ? [] : [i]));
  if (spans) return known.length === 1 ? known : [];
  return known.filter((i) => (column[i - 1] ?? null) === null && (column[i + 1] ?? null) === null);
}

/** Handed over per hour of factory time, over all that was seen; null of nothing. The same as a shift that is played tells in the editor. */
export function transportsPerHour({ items }: KpiHistory): number | null {
  const spanS = items.reduce((sum, point) => sum + point.span_s, 0);
  const count = items.reduce((sum, point) => sum + point.transports, 0);
  return spanS > 0 ? (count * 3600) / spanS : null;
}

/** The newest figure that is known. */
export function lastOf(column: Column): number | null {
  return column.findLast((value) => value !== null) ?? null;
}
