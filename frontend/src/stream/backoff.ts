/** How long to wait before the next try to connect. */

/** A restart of the gateway takes about a second, so the first try comes soon. */
const FIRST_S = 0.5;
/** A person who watches must not wait longer than this after the gateway is back. */
const LONGEST_S = 8;

/**
 * Doubles with every failed try; a quarter of it is chance, so that a hundred tablets do not come
 * back in the same moment.
 *
 * @param failures tries that failed in a row, 0 for the first wait
 * @param chance a number from 0 to 1
 */
export function waitBeforeS(failures: number, chance: number): number {
  const whole = Math.min(LONGEST_S, FIRST_S * 2 ** failures);
  return whole * (0.75 + 0.25 * chance);
}
