/** A film of the past: a picture, and the frames that follow it. Pure. */
import type { components } from "../../../api/types";
import { advance, type Frame, type World, worldOf } from "../../../stream/world";

export type Film = components["schemas"]["FilmView"];
export type Mark = components["schemas"]["Mark"];
export type Overview = components["schemas"]["OverviewView"];

export interface Reel {
  readonly world: World;
  readonly frames: readonly Frame[];
  /** The next frame to show. */
  readonly next: number;
  /** How far it goes, seconds since 1970. */
  readonly untilS: number;
}

export function reelOf(film: Film): Reel {
  return { world: worldOf(film.snapshot), frames: film.frames, next: 0, untilS: film.until_at_s };
}

/** The reel when it has come to a moment, and the frames that were shown on the way there. */
export function play(reel: Reel, untilS: number): { reel: Reel; shown: Frame[] } {
  let { next, world } = reel;
  const shown: Frame[] = [];
  for (; next < reel.frames.length; next += 1) {
    const frame = reel.frames[next];
    if (frame === undefined || frame.at_s > untilS) break;
    const after = advance(world, frame);
    if (after === null) break;
    world = after;
    shown.push(frame);
  }
  return { reel: { ...reel, next, world }, shown };
}

/** How much of a film is fetched at once, in real seconds of the past: half a minute of looking at it. */
export function aheadS(rate: number): number {
  return Math.min(1800, Math.max(20, 30 * rate));
}

/** Frames closer together than this are told in one: eight pictures a second are enough where time runs. */
export function everyS(rate: number): number {
  return rate > 4 ? rate / 8 : 0;
}

/** The mark before a moment, or after it; null where there is none. Half a second is the same moment. */
export function markBeside(marks: readonly Mark[], atS: number, direction: -1 | 1): Mark | null {
  const beside = marks.filter((mark) => (mark.at_s - atS) * direction > 0.5);
  return beside.at(direction === 1 ? 0 : -1) ?? null;
}

export interface Range {
  readonly fromS: number;
  readonly toS: number;
}

/** A time of a length that holds a moment: up to now where that holds it, else with the moment in its middle. */
export function rangeAround(atS: number, lengthS: number, nowS: number): Range {
  const toS = atS > nowS - lengthS ? nowS : Math.min(nowS, atS + lengthS / 2);
  return { fromS: toS - lengthS, toS };
}
