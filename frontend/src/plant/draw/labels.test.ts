import { describe, expect, test } from "vitest";
import { overlaps, type Rect } from "../surface/geometry";
import { placed, placesAlong, placesAround, type Wish, within } from "./labels";

const size = { width: 30, height: 12 };
const middle = { x: 100, y: 100 };
const name = (must: boolean): Wish => ({ ...size, must, places: placesAround(middle, size, 10, must) });
const free = { things: [], words: [] };
const all: Rect = { left: -1000, right: 1000, top: -1000, bottom: 1000 };
const above: Rect = { left: 80, right: 120, top: 60, bottom: 92 };

describe("a vehicle's name", () => {
  test("stands above it, beside it where something is above, and nowhere in a crowd", () => {
    expect(placed([name(false)], free)[0]?.bottom).toBe(90);
    expect(placed([name(false)], { ...free, things: [above] })[0]?.left).toBeGreaterThan(100);
    expect(placed([name(false)], { ...free, things: [all] })).toEqual([null]);
  });

  test("of the chosen one covers a machine, and never a word", () => {
    expect(placed([name(true)], { ...free, things: [all] })[0]?.bottom).toBe(90);
    expect(placed([name(true)], { things: [all], words: [above] })[0]?.left).toBeGreaterThan(100);
    expect(placed([name(true)], { ...free, words: [all] })).toEqual([null]);
  });

  test("of the chosen one covers a machine before it covers another vehicle, and as few of them as can be", () => {
    expect(placed([name(true)], { things: [all, above], vehicles: [above], words: [] })[0]?.left).toBeGreaterThan(100);
    const left: Rect = { left: -1000, right: 95, top: -1000, bottom: 1000 };
    expect(placed([name(true)], { things: [all, left, above], vehicles: [all, left, above], words: [] })[0]?.left).toBeGreaterThan(100);
    expect(placed([name(true)], { things: [all], vehicles: [all], words: [] })[0]?.bottom).toBe(90);
  });

  test("keeps clear of those that matter more", () => {
    const [first, second] = placed([name(false), name(false)], free);
    expect(first && second && overlaps(first, second)).toBe(false);
  });
});

test("an age stands in the middle of its line, else beside it, where the machine's name is not", () => {
  const places = placesAlong({ x: 0, y: 0 }, { x: 400, y: 0 });
  const age: Wish = { ...size, must: true, places };
  const at = (words: Rect[]) => placed([age], { ...free, words }).map((rect) => rect && (rect.left + rect.right) / 2);
  expect(at([])).toEqual([200]);
  expect(at([{ left: 180, right: 220, top: -8, bottom: 8 }])).toEqual([136]);
});

test("a sign stands where no words are, over a machine if it must be, and at its first place where there is no other", () => {
  const sign: Wish = { ...size, must: true, always: true, places: [{ x: 100, y: 100 }, { x: 100, y: 140 }] };
  const at = (things: Rect[], words: Rect[]) => placed([sign], { things, words })[0]?.top;
  const [one, other] = [{ left: 90, right: 110, top: 95, bottom: 105 }, { left: 90, right: 110, top: 135, bottom: 145 }];
  expect(at([], [])).toBe(94);
  expect(at([one], [])).toBe(134);
  expect(at([], [one])).toBe(134);
  expect(at([one], [other])).toBe(94);
  expect(at([], [one, other])).toBe(94);
});

test("what would stand over the edge of the map is moved into it", () => {
  const room = { width: 200, height: 100 };
  expect(within({ x: 5, y: 300 }, size, room)).toEqual({ x: 15, y: 94 });
  expect(within({ x: 60, y: 50 }, size, room)).toEqual({ x: 60, y: 50 });
  expect(within({ x: 60, y: 50 }, { width: 300, height: 12 }, room)).toEqual({ x: 100, y: 50 });
});

/** Chance that is the same each time. */
function chance(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** A map of so many vehicles and machines, their names, and the ages of those that are watched. */
function plant(seed: number, vehicles: number, machines: number): { wishes: Wish[]; taken: { things: Rect[]; words: Rect[] } } {
  const next = chance(seed);
  const [width, height] = [400 + 2000 * next(), 300 + 1000 * next()];
  const at = () => ({ x: width * next(), y: height * next() });
  // In rows, as machines stand.
  const columns = Math.ceil(Math.sqrt(machines));
  const things = Array.from({ length: machines }, (_, i) => {
    const [left, top] = [(width / columns) * (i % columns), (height / columns) * Math.floor(i / columns)];
    return { left, top, right: left + (0.7 * width) / columns, bottom: top + (0.5 * height) / columns };
  });
  const words = things.map(({ bottom, left, right, top }) => {
    const [x, y] = [(left + right) / 2, (top + bottom) / 2];
    const half = Math.min(10, (right - left) / 2);
    return { left: x - half, right: x + half, top: y - 5, bottom: y + 5 };
  });
  const awayPx = 5 + 12 * next();
  const named = Array.from({ length: vehicles }, (_, i): Wish => {
    const own = { width: 20 + 60 * next(), height: 12 };
    return { ...own, must: i < 2, places: placesAround(at(), own, awayPx, i < 2) };
  });
  const aged = Array.from({ length: Math.ceil(vehicles / 5) }, (): Wish => ({ width: 28, height: 13, must: true, places: placesAlong(at(), at()) }));
  return { wishes: [...named.slice(0, 2), ...aged, ...named.slice(2)], taken: { things, words } };
}

const PLANTS = [[50, 40], [50, 200], [240, 200], [1, 1]] as const;

test.each(PLANTS)("no two words stand in one another: %i vehicles among %i machines", (vehicles, machines) => {
  for (let seed = 1; seed <= Math.ceil(24_000 / (vehicles + machines)) && seed <= 100; seed += 1) {
    const { taken, wishes } = plant(seed, vehicles, machines);
    const rects = placed(wishes, taken);
    const written = [...taken.words, ...rects.filter((rect) => rect !== null)];
    expect(rects).toHaveLength(wishes.length);
    // Two machines may be as near to one another as somebody has drawn them.
    const wrong = written.filter((rect, i) => written.slice(Math.max(i + 1, taken.words.length)).some((other) => overlaps(rect, other)));
    expect(wrong, `seed ${seed}`).toEqual([]);
    // What need not be told covers no machine either.
    const covering = rects.filter((rect, i) => rect && !wishes[i]?.must && taken.things.some((thing) => overlaps(rect, thing)));
    expect(covering, `seed ${seed}`).toEqual([]);
    // Each stands where it wished to.
    const strayed = rects.filter((rect, i) => rect && !wishes[i]?.places.some((place) => isMiddle(rect, place)));
    expect(strayed, `seed ${seed}`).toEqual([]);
  }
});

function isMiddle(rect: Rect, { x, y }: { x: number; y: number }): boolean {
  return Math.hypot((rect.left + rect.right) / 2 - x, (rect.top + rect.bottom) / 2 - y) < 0.001;
}

test("most of the names of a plant of 50 vehicles have a place", () => {
  const { taken, wishes } = plant(7, 50, 40);
  expect(placed(wishes, taken).filter((rect) => rect !== null).length).toBeGreaterThan(0.6 * wishes.length);
});
