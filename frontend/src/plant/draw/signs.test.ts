/** Signs of jams, of what people have closed, and of doors that have failed: beside the words that are there before. */
import { describe, expect, test } from "vitest";
import type { ClosureView, PlantFile } from "../../api/types";
import type { Roads } from "../../motion/roads";
import { drawDoors } from "../doors/doors";
import { jamSigns } from "../held/draw";
import type { Jam } from "../held/held";
import { overlaps, type Rect } from "../surface/geometry";
import type { Brush } from "./brush";
import { drawClosures } from "./closures";

/** Ten pixels of a metre, y up from 1000, letters of eight pixels; it notes what is written, and where. */
function brushOn(size = { width: 1000, height: 1000 }, scale = 10) {
  const written: [string, number, number][] = [];
  const nothing = (): void => undefined;
  const ctx = new Proxy({ measureText: (text: string) => ({ width: 8 * text.length }), fillText: (...told: [string, number, number]) => { written.push(told); } }, {
    get: (target, name) => (name in target ? (target as Record<string | symbol, unknown>)[name] : nothing),
    set: () => true,
  });
  const view = { scale, x0: 0, y0: 1000 };
  return { brush: { ctx, size, view, palette: { font: "sans-serif" }, detail: { vehiclePx: 10 } } as unknown as Brush, written };
}

const FREE = { things: [], words: [] };

const rect = (x: number, y: number, width = 30, height = 14): Rect => ({ left: x - width / 2, right: x + width / 2, top: y - height / 2, bottom: y + height / 2 });

const overlapping = (rects: readonly Rect[]): [Rect, Rect][] =>
  rects.flatMap((one, i) => rects.slice(i + 1).filter((other) => overlaps(one, other)).map((other): [Rect, Rect] => [one, other]));

describe("the sign of a jam", () => {
  const jam = (...line: [number, number][]): Jam & { text: string } => {
    const points = line.map(([x, y]) => ({ x, y }));
    const lines = points.map((from, i) => ({ from, to: points[i + 1] ?? from }));
    return { alert: {}, sinceAtS: 0, lines, text: "Jam 2:02 min" } as unknown as Jam & { text: string };
  };
  const signs = (jams: (Jam & { text: string })[], taken = FREE as { things: Rect[]; words: Rect[] }, size?: { width: number; height: number }) =>
    jamSigns(brushOn(size).brush, jams, taken).map((sign) => sign.rect);

  test("stands above it where nothing is", () => {
    const [sign] = signs([jam([50, 50], [50, 44])]);
    expect(sign).toMatchObject({ top: 446, bottom: 466 });
    expect(((sign?.left ?? 0) + (sign?.right ?? 0)) / 2).toBe(500);
  });

  test("covers no names of machines on both sides of the lane", () => {
    const names = [rect(455, 456), rect(545, 456)];
    const [sign] = signs([jam([50, 50], [50, 44])], { things: [], words: names });
    expect(sign && overlapping([sign, ...names])).toEqual([]);
  });

  test("covers no machine as long as there is a place beside it, and no name where there is none", () => {
    const machine = rect(500, 450, 400, 100);
    const [beside] = signs([jam([50, 50], [50, 44])], { things: [machine], words: [] });
    expect(beside && overlaps(beside, machine)).toBe(false);
    const all = rect(500, 500, 2000, 2000);
    const name = rect(500, 456);
    const [over] = signs([jam([50, 50], [50, 44])], { things: [all], words: [name] });
    expect(over && overlaps(over, name)).toBe(false);
  });

  test("is told where there is no place at all, and within the map", () => {
    const all = rect(500, 500, 2000, 2000);
    expect(signs([jam([50, 99], [50, 98])], { things: [], words: [all] })).toHaveLength(1);
    const size = { width: 300, height: 200 };
    for (const [x, y] of [[0, 81], [29, 99], [15, 90]] as const) {
      for (const sign of signs([jam([x, y])], FREE, size)) {
        expect(sign.left).toBeGreaterThanOrEqual(0);
        expect(sign.right).toBeLessThanOrEqual(size.width);
        expect(sign.top).toBeGreaterThanOrEqual(0);
        expect(sign.bottom).toBeLessThanOrEqual(size.height);
      }
    }
    expect(signs([jam([500, 500])])).toEqual([]);
  });

  test("of two that are near one another stands beside the other one's", () => {
    const two = signs([jam([50, 50], [50, 44]), jam([53, 50], [53, 44])]);
    expect(two).toHaveLength(2);
    expect(overlapping(two)).toEqual([]);
  });
});

const PLACES = new Map([["a", { x: 40, y: 50 }], ["b", { x: 60, y: 50 }], ["c", { x: 42, y: 50 }], ["d", { x: 62, y: 50 }], ["e", { x: 40, y: 30 }], ["f", { x: 60, y: 30 }]]);
const roads = { places: PLACES } as unknown as Roads;

describe("the words on what people have closed", () => {
  const slow = (start: string, end: string): ClosureView =>
    ({ kind: "slow", outline: [], lanes: [{ start, end }], lane: { start, end }, speed_mps: 0.5, until_at_s: null }) as unknown as ClosureView;
  const shut = (start: string, end: string): ClosureView =>
    ({ ...slow(start, end), kind: "closed", speed_mps: null, until_at_s: 1_900_000_000 });
  const drawn = (closures: ClosureView[], words: Rect[] = [], things: Rect[] = []) => {
    const { brush, written } = brushOn();
    return { rects: drawClosures(brush, roads, closures, 1_899_990_000, { things, words }), written };
  };

  test("stand on a slow lane, and below the sign of a closed one, which is told as well", () => {
    expect(drawn([slow("a", "b")]).written).toEqual([[expect.stringContaining("0.5"), 500, 508]]);
    const { rects: [sign, words] } = drawn([shut("a", "b")]);
    expect(sign).toEqual({ left: 492, right: 508, top: 492, bottom: 508 });
    expect(words?.top).toBe(512);
  });

  test("stand beside the names that are there, and beside one another", () => {
    const names = [rect(500, 508), rect(500, 492), rect(500, 720)];
    const { rects } = drawn([slow("a", "b"), slow("c", "d"), shut("e", "f")], names);
    expect(rects).toHaveLength(4);
    expect(overlapping([...names, ...rects])).toEqual([]);
  });

  test("cover no machine where there is room beside it", () => {
    const machine = rect(500, 540, 200, 60);
    const { rects } = drawn([shut("a", "b")], [], [machine]);
    expect(overlapping([machine, ...rects])).toEqual([]);
  });
});

describe("the name of a door that has failed", () => {
  const door: PlantFile["doors"][number] = { id: "GATE", name: "Gate", lanes: [{ start: "a", end: "b" }], opening_s: 8, closes_after_s: 5 };
  const failed = { atvs: new Map(), obstacles: new Map([["1", { start: "a", end: "b" }]]), waits: new Map() } as unknown as Parameters<typeof drawDoors>[3];
  const drawn = (words: Rect[]) => {
    const { brush, written } = brushOn(undefined, 20);
    return { rects: drawDoors(brush, roads, [door], failed, true, { things: [], words }), written };
  };

  test("stands at the end where the sign is not, behind the sign where other words are there, and nowhere where they are at both", () => {
    const { rects: [sign, name] } = drawn([]);
    expect(sign && name && overlaps(sign, name)).toBe(false);
    const { rects: [, behind] } = drawn(name ? [name] : []);
    expect(behind && name && overlaps(behind, name)).toBe(false);
    expect(behind && sign && overlaps(behind, sign)).toBe(false);
    const none = drawn([name, behind].filter((each) => each !== undefined));
    expect(none.rects).toEqual([sign]);
    expect(none.written).toEqual([]);
  });
});
