/**
 * Where words stand on the map, so that no two of them stand in one another. Geometry only: `words.ts` measures and
 * writes them.
 */
import { overlaps, type Rect } from "../surface/geometry";

interface Point {
  readonly x: number;
  readonly y: number;
}

/** Words that want a place. */
export interface Wish {
  readonly width: number;
  readonly height: number;
  /** Where their middle may be, the best first. */
  readonly places: readonly Point[];
  /** Told even where a thing must be covered for it; never where other words stand. */
  readonly must: boolean;
  /** A sign on a ground of its own: where words stand at all its places, it covers those at the first one. */
  readonly always?: boolean;
}

/** What is there before. */
export interface Taken {
  /** Vehicles, machines and storages: covered by what must be told, and by nothing else. */
  readonly things: readonly Rect[];
  /** The vehicles among these: what must be told covers a machine before it covers one of them. */
  readonly vehicles?: readonly Rect[];
  /** Words that stand where they stand: covered by nothing. */
  readonly words: readonly Rect[];
}

/**
 * One place for each wish, in their order: the earlier, the more it matters. Null where there is none.
 */
export function placed(wishes: readonly Wish[], { things, vehicles = [], words }: Taken): (Rect | null)[] {
  const written = [...words];
  return wishes.map((wish) => {
    const legible = wish.places.map((place) => around(place, wish)).filter((rect) => !covers(rect, written));
    const rect = legible.find((each) => !covers(each, things)) ?? (wish.must ? overFewest(legible, vehicles) : undefined) ?? (wish.always ? first(wish) : null);
    if (rect) written.push(rect);
    return rect;
  });
}

/**
 * Around a vehicle: above it, at its sides, below it. Of one that must be named also at its shoulders, and once more
 * farther out.
 */
export function placesAround(middle: Point, { height, width }: { width: number; height: number }, awayPx: number, must: boolean): Point[] {
  const ring = (farPx: number): Point[] => {
    const [dx, dy] = [farPx + width / 2 + 1, farPx + height / 2];
    return [[0, -dy], [dx, 0], [-dx, 0], [0, dy]].map((each) => from(middle, each));
  };
  if (!must) return ring(awayPx);
  const shoulders = (farPx: number): Point[] => {
    const [dx, dy] = [0.7 * farPx + width / 2, 0.7 * farPx + height / 2];
    return [[dx, -dy], [-dx, -dy], [dx, dy], [-dx, dy]].map((each) => from(middle, each));
  };
  return [awayPx, awayPx + height].flatMap((farPx) => [...ring(farPx), ...shoulders(farPx)]);
}

function from({ x, y }: Point, [dx = 0, dy = 0]: number[]): Point {
  return { x: x + dx, y: y + dy };
}

/** Parts of a line, the middle first. */
const ALONG = [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74] as const;

/** On a line, as near to its middle as can be. */
export function placesAlong(a: Point, b: Point): Point[] {
  return ALONG.map((part) => ({ x: a.x + part * (b.x - a.x), y: a.y + part * (b.y - a.y) }));
}

/** Inside of some room; in the middle of it, where there is less of it than the words need. */
export function within({ x, y }: Point, { height, width }: { width: number; height: number }, room: { width: number; height: number }): Point {
  const clamp = (at: number, half: number, most: number): number => (most < 2 * half ? most / 2 : Math.min(Math.max(at, half), most - half));
  return { x: clamp(x, width / 2, room.width), y: clamp(y, height / 2, room.height) };
}

/** The first of those that cover the fewest. */
function overFewest(rects: readonly Rect[], vehicles: readonly Rect[]): Rect | undefined {
  const covered = rects.map((rect) => vehicles.filter((vehicle) => overlaps(rect, vehicle)).length);
  return rects[covered.indexOf(Math.min(...covered))];
}

function first(wish: Wish): Rect | null {
  const [place] = wish.places;
  return place ? around(place, wish) : null;
}

function around({ x, y }: Point, { height, width }: Wish): Rect {
  return { left: x - width / 2, right: x + width / 2, top: y - height / 2, bottom: y + height / 2 };
}

function covers(rect: Rect, others: readonly Rect[]): boolean {
  return others.some((other) => overlaps(rect, other));
}
