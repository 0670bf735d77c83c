/**
 * The places of the Stop bar. Whoever is near has one that is in sight. A hand that moves towards a Stop must meet the
 * vehicle that it has seen there, so a vehicle keeps its place while it is near, and while a hand may be over it. Pure.
 *
 * A joining vehicle takes a free place, else the next one in sight, else that of the vehicle that has been away for longest. A
 * near vehicle that is out of sight moves as soon as somebody in sight leaves. In each case the place has a new owner, and
 * touches on it do not count at first: they were meant for what was there before.
 */

export interface Place {
  readonly atv: string;
  /** Whether it is near; has left a moment ago, or a Stop to it is not confirmed; or has left, and nobody has the place. */
  readonly state: "near" | "left" | "free";
  /** When it was near last. */
  readonly seenAtMs: number;
  /** Since when this place is its own; -Infinity where it was there from the beginning. */
  readonly givenAtMs: number;
}

/** A hand over a Stop is down by then. Then nothing is shown there. */
export const KEPT_MS = 3_000;

/** A hand that has set out takes this long to arrive, and a person this long to see a change. */
export const SETTLE_MS = 500;

/**
 * @param present ids of the vehicles that are near, in the order in which joining vehicles are seated
 * @param bound those that have a place wherever they are: a Stop to them is not confirmed
 * @param inSight how many places can be seen at once
 * @returns the very same places where nothing has changed
 */
export function seated(
  before: readonly Place[],
  present: readonly string[],
  bound: ReadonlySet<string>,
  inSight: number,
  nowMs: number,
): readonly Place[] {
  const near = new Set(present);
  const after = before.map((place) => lookedAt(place, near, bound, nowMs));
  const known = new Set(before.map(({ atv }) => atv));
  const givenAtMs = before.length === 0 ? -Infinity : nowMs;
  for (const atv of new Set([...present, ...bound])) {
    if (known.has(atv)) continue;
    const state = near.has(atv) ? "near" : "left";
    after.splice(placeFor(after, bound, inSight), 1, { atv, state, seenAtMs: nowMs, givenAtMs });
  }
  showAllNear(after, bound, inSight, nowMs);
  const end = after.findLastIndex(({ state }) => state !== "free");
  const kept = after.slice(0, end + 1);
  return kept.length === before.length && kept.every((place, i) => isSame(place, before[i])) ? before : kept;
}

function lookedAt(place: Place, near: ReadonlySet<string>, bound: ReadonlySet<string>, nowMs: number): Place {
  if (near.has(place.atv)) {
    const givenAtMs = place.state === "free" ? nowMs : place.givenAtMs;
    return { ...place, state: "near", seenAtMs: nowMs, givenAtMs };
  }
  const seenAtMs = place.state === "near" ? nowMs : place.seenAtMs;
  const isFree = place.state === "free" || nowMs - seenAtMs >= KEPT_MS;
  return { ...place, state: isFree && !bound.has(place.atv) ? "free" : "left", seenAtMs };
}

/** Where somebody is seated who comes: a free place, the next one in sight, one whose vehicle has left, or the end. */
function placeFor(places: readonly Place[], bound: ReadonlySet<string>, inSight: number): number {
  const free = places.findIndex(({ state }) => state === "free");
  if (free >= 0) return free;
  const left = places.length < inSight ? -1 : longestAway(places, bound, inSight);
  return left < 0 ? places.length : left;
}

function longestAway(places: readonly Place[], bound: ReadonlySet<string>, inSight: number): number {
  let found = -1;
  for (const [i, { atv, state, seenAtMs }] of places.slice(0, inSight).entries()) {
    if (state === "near" || bound.has(atv)) continue;
    if (found < 0 || seenAtMs < (places[found]?.seenAtMs ?? 0)) found = i;
  }
  return found;
}

/** Whoever is near and out of sight changes places with somebody in sight who is not near. */
function showAllNear(places: Place[], bound: ReadonlySet<string>, inSight: number, nowMs: number): void {
  for (let i = inSight; i < places.length; i++) {
    const hidden = places[i];
    if (hidden?.state !== "near") continue;
    let to = longestAway(places, bound, inSight);
    // A Stop that is not confirmed is told of above the bar as well.
    if (to < 0) to = places.slice(0, inSight).findIndex(({ state }) => state !== "near");
    const other = places[to];
    if (!other) return;
    places[to] = { ...hidden, givenAtMs: nowMs };
    places[i] = { ...other, state: bound.has(other.atv) ? "left" : "free", givenAtMs: nowMs };
  }
}

/** When somebody was near last matters only once it is away. */
function isSame(a: Place, b: Place | undefined): boolean {
  return a.atv === b?.atv && a.state === b.state && a.givenAtMs === b.givenAtMs;
}

/** Milliseconds for which touches on a place do not count yet; 0 when they do. */
export function settlesInMs(place: Pick<Place, "givenAtMs">, movedAtMs: number, nowMs: number): number {
  return Math.max(0, Math.max(place.givenAtMs, movedAtMs) + SETTLE_MS - nowMs);
}
