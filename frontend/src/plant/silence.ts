/** When silence of one agent means that its place on the map is a memory. */

/** An idle vehicle speaks every five factory seconds; two beats may be missed. */
const BEATS_S = 15;
/** However fast the factory runs: browsers are told ten times a second at most. */
const LEAST_S = 3;

/** @param speed factory seconds per real second */
export function isLost(view: { seen_at_s: number }, nowS: number, speed: number): boolean {
  return nowS - view.seen_at_s > Math.max(LEAST_S, BEATS_S / Math.max(speed, 0.1));
}
