/** A part of the floor that somebody draws on the map, corner by corner, to close it. */
import { signal } from "@preact/signals";

/** x and y on the floor (m). */
export type Corner = readonly [number, number];

export interface Outline {
  /** Whether a click on the map sets a corner. */
  readonly drawing: boolean;
  readonly corners: readonly Corner[];
}

/** As many as the gateway takes. */
export const MOST_CORNERS = 12;

export const NOTHING_DRAWN: Outline = { drawing: false, corners: [] };

export const outline = signal<Outline>(NOTHING_DRAWN);

/** With one corner more, on the floor and to the centimetre; as before when there are enough. */
export function withCorner(before: Outline, x: number, y: number, floor: { width_m: number; height_m: number }): Outline {
  if (before.corners.length >= MOST_CORNERS) return before;
  const on = (m: number, end: number): number => Math.round(Math.min(Math.max(m, 0), end) * 100) / 100;
  return { ...before, corners: [...before.corners, [on(x, floor.width_m), on(y, floor.height_m)]] };
}

/** The shape that corners stand for: two are opposite corners of a rectangle; one is no shape yet. */
export function shapeOf(corners: readonly Corner[]): readonly Corner[] {
  const [a, b] = corners;
  if (!a || !b) return [];
  return corners.length > 2 ? corners : [a, [b[0], a[1]], b, [a[0], b[1]]];
}
