/**
 * The places of the Stop bar. A hand that moves towards a Stop must meet the vehicle that it has seen there, so
 * a vehicle keeps its place while it is near and for a while after it has left. Pure.
 *
 * Joining vehicles come to the end, or into a place whose vehicle has been away for long. Either way the place has a
 * new owner, and touches on it do not count at first: they were meant for what was there before.
 */

export interface Place {
  readonly atv: string;
  /** Whether it is near at this moment. */
  readonly present: boolean;
  /** When it was near last. */
  readonly seenAtMs: number;
  /** Since when this place is its own; -Infinity where it was there from the beginning. */
  readonly givenAtMs: number;
}

/** Longer than a vehicle takes for a way through the next area and back; then the place may be given away. */
export const KEPT_MS = 120_000;

/** A hand that has set out takes this long to arrive, and a person this long to see a change. */
export const SETTLE_MS = 500;

/**
 * @param present ids of the vehicles that are near, in the order in which joining vehicles are seated
 * @param bound those that have a place wherever they are: a Stop to them is not confirmed
 * @returns the very same places where nothing has changed
 */
export function seated(
  before: readonly Place[],
  present: readonly string[],
  bound: ReadonlySet<string>,
  nowMs: number,
): readonly Place[] {
  const near = new Set(present);
  const after = before.map((place) => (near.has(place.atv) || place.present ? seen(place, near, nowMs) : place));
  const isVacant = (place: Place): boolean =>
    !place.present && !bound.has(place.atv) && nowMs - place.seenAtMs >= KEPT_MS;
  const known = new Set(before.map(({ atv }) => atv));
  const givenAtMs = before.length === 0 ? -Infinity : nowMs;
  for (const atv of new Set([...present, ...bound])) {
    if (known.has(atv)) continue;
    const vacant = after.findIndex(isVacant);
    after.splice(vacant < 0 ? after.length : vacant, 1, { atv, present: near.has(atv), seenAtMs: nowMs, givenAtMs });
  }
  // At the end nobody moves when one goes.
  const end = after.findLastIndex((place) => !isVacant(place));
  const kept = after.slice(0, end + 1);
  return kept.length === before.length && kept.every((place, i) => isSame(place, before[i])) ? before : kept;
}

function seen(place: Place, near: ReadonlySet<string>, nowMs: number): Place {
  return near.has(place.atv)
    ? { ...place, present: true, seenAtMs: nowMs }
    : { ...place, present: false, seenAtMs: nowMs };
}

/** When somebody was near last matters only once it is away. */
function isSame(a: Place, b: Place | undefined): boolean {
  return a.atv === b?.atv && a.present === b.present && a.givenAtMs === b.givenAtMs;
}

/** Milliseconds for which touches on a place do not count yet; 0 when they do. */
export function settlesInMs(place: Pick<Place, "givenAtMs">, movedAtMs: number, nowMs: number): number {
  return Math.max(0, Math.max(place.givenAtMs, movedAtMs) + SETTLE_MS - nowMs);
}
