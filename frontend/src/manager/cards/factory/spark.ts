/** Geometry of a sparkline. */

/** Points of the line, from left to right; zero is the bottom, so that a small change stays small. */
export function sparkPoints(values: readonly number[], width: number, height: number): [number, number][] {
  const most = Math.max(1, ...values);
  const step = values.length > 1 ? width / (values.length - 1) : 0;
  return values.map((value, i) => [i * step, height - (value / most) * height]);
}
