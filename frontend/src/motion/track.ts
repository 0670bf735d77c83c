/**
 * Where one vehicle was, as knots in time, so that it can be shown moving along its lanes although
 * its heartbeats come a second apart.
 *
 * The map plays the tracks a little late (see `playback`). It therefore draws only what has truly
 * happened, between one heartbeat and the next: no vehicle is ever shown where it was not, and none
 * has to be pulled back.
 */
import { hopsBetween, type Place, type Roads } from "./roads";

export interface Knot extends Place {
  /** Server's wall clock. */
  readonly t: number;
}

/** What a heartbeat says about where a vehicle is. */
export interface Sighting extends Place {
  readonly t: number;
  readonly node: string;
  readonly way: readonly string[];
  readonly heading: number;
}

export interface Track {
  readonly knots: readonly Knot[];
  readonly last: Sighting;
}

/** Shown pose; `moving` is false where nothing more is known to happen. */
export interface Pose extends Place {
  readonly heading: number;
  readonly moving: boolean;
}

/** Faster than any vehicle in any replay: what covers more was set down there, not driven. */
const LEAP_M = 60;
/** Late news is caught up with within this time: soon, but still seen as driving. */
const CATCH_UP_S = 1;
/** Knots closer than this are the same place. */
const SAME_M = 0.01;

export function trackOf(seen: Sighting): Track {
  return { knots: [{ x: seen.x, y: seen.y, t: seen.t }], last: seen };
}

/**
 * The track with one more sighting.
 *
 * @param playedS the time that is on the screen now: what lies before it is dropped, and a vehicle
 *   that stood until now starts from there, not from some moment in the past
 */
export function extend(track: Track, seen: Sighting, roads: Roads, playedS: number): Track {
  const last = track.knots.at(-1);
  const sinceS = seen.t - track.last.t;
  if (!last || sinceS <= 0) return { knots: track.knots, last: seen };
  const path = drivenPath(track.last, seen, roads);
  if (path === null) return trackOf(seen);
  const start = Math.max(last.t, playedS);
  // News that came too late is not leapt over but driven, quicker than news comes.
  const end = Math.max(seen.t, start + Math.min(CATCH_UP_S, sinceS / 2));
  const kept = recent(track.knots, playedS);
  if (start > last.t) kept.push({ x: last.x, y: last.y, t: start });
  kept.push(...spread(path, start, end));
  return { knots: kept, last: seen };
}

/** The points from one sighting to the next along the lanes; null where it cannot have been driven. */
export function drivenPath(from: Sighting, to: Sighting, roads: Roads): Place[] | null {
  if (Math.hypot(to.x - from.x, to.y - from.y) > LEAP_M) return null;
  const between = nodesBetween(from, to, roads);
  const points: Place[] = [from];
  for (const id of between) {
    const place = roads.places.get(id);
    if (place) points.push(place);
  }
  points.push(to);
  return points;
}

function nodesBetween(from: Sighting, to: Sighting, roads: Roads): readonly string[] {
  if (to.node === from.node) return [];
  const passed = from.way.indexOf(to.node);
  if (passed >= 0) return from.way.slice(0, passed + 1);
  const first = from.way[0];
  // Sent another way meanwhile: it went on to the next node, or turned back at the one behind it.
  const onward = first === undefined ? null : hopsBetween(roads, first, to.node);
  const back = hopsBetween(roads, from.node, to.node);
  if (onward && (!back || onward.length < back.length)) return onward;
  return back ?? [];
}

/** Gives every point its time, as if the way had been driven at one speed. */
function spread(path: readonly Place[], startS: number, endS: number): Knot[] {
  const lengths = path.map((point, i) => distance(path[i - 1] ?? point, point));
  const whole = lengths.reduce((sum, length) => sum + length, 0);
  const last = path.at(-1);
  if (!last) return [];
  if (whole < SAME_M) return [{ x: last.x, y: last.y, t: endS }];
  let driven = 0;
  const knots: Knot[] = [];
  path.forEach((point, i) => {
    const length = lengths[i] ?? 0;
    driven += length;
    if (i > 0 && length > 0) {
      knots.push({ x: point.x, y: point.y, t: startS + (endS - startS) * (driven / whole) });
    }
  });
  return knots;
}

/** From the last knot that lies before `playedS` on. */
function recent(knots: readonly Knot[], playedS: number): Knot[] {
  let from = 0;
  while (from + 1 < knots.length && (knots[from + 1]?.t ?? Infinity) <= playedS) from += 1;
  return knots.slice(from);
}

function distance(a: Place, b: Place): number {
  return Math.hypot(b.x - a.x, b.y - a.y);
}

/** Where the vehicle is shown at a moment. */
export function poseAt(track: Track, atS: number): Pose {
  const { knots, last } = track;
  const end = knots.length - 1;
  let i = end;
  while (i > 0 && (knots[i]?.t ?? 0) > atS) i -= 1;
  const a = knots[i];
  const b = knots[i + 1];
  if (!a || !b) return { x: (a ?? last).x, y: (a ?? last).y, heading: last.heading, moving: false };
  const part = clamp01((atS - a.t) / (b.t - a.t));
  const dx = b.x - a.x;
  const dy = b.y - a.y;
  const drives = Math.abs(dx) + Math.abs(dy) > SAME_M;
  return {
    x: a.x + dx * part,
    y: a.y + dy * part,
    heading: drives ? Math.atan2(dy, dx) : last.heading,
    // Later knots count as motion too: the picture has to go on until they are played.
    moving: drives || movesAfter(knots, i + 1),
  };
}

/** Whether any knot lies elsewhere than this one. */
function movesAfter(knots: readonly Knot[], from: number): boolean {
  const here = knots[from];
  for (let i = from + 1; i < knots.length; i += 1) {
    const knot = knots[i];
    if (here && knot && distance(here, knot) > SAME_M) return true;
  }
  return false;
}

function clamp01(value: number): number {
  return Math.min(1, Math.max(0, value));
}

/** A heading on its way to another, the short way round. */
export function turnTowards(heading: number, target: number, part: number): number {
  const round = 2 * Math.PI;
  const difference = ((((target - heading) % round) + round + Math.PI) % round) - Math.PI;
  return heading + difference * clamp01(part);
}
