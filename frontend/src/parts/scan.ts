/** What a scanner that types like a keyboard has read: characters in quick succession, and Enter. Pure. */

/** A scanner types faster than this, a hand does not. */
const GAP_MS = 300;

/** A code that was read in part. */
export interface Scan {
  readonly text: string;
  readonly atMs: number;
}

export const NOTHING: Scan = { text: "", atMs: 0 };

/**
 * Takes a key in.
 *
 * @param key as `KeyboardEvent.key` has it
 * @param atMs when, on any clock that goes on
 * @returns what was read so far, and the code where that is whole
 */
export function pressed(scan: Scan, key: string, atMs: number): readonly [Scan, string | null] {
  const goesOn = atMs - scan.atMs <= GAP_MS;
  if (key === "Enter") return [NOTHING, goesOn && scan.text.length > 1 ? scan.text : null];
  if (key.length !== 1) return [scan, null];
  return [{ text: goesOn ? scan.text + key : key, atMs }, null];
}
