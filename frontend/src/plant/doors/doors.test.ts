import { describe, expect, test } from "vitest";
import type { AtvView, ObstacleView, PlantFile } from "../../api/types";
import type { Roads } from "../../motion/roads";
import type { Brush } from "../draw/brush";
import { drawDoors, lookOf, type Told } from "./doors";

type Door = PlantFile["doors"][number];

const DOOR: Door = { id: "GATE", name: "Gate", lanes: [{ start: "a", end: "b" }], opening_s: 8, closes_after_s: 5 };
const PLACES = new Map([["a", { x: 0, y: 0 }], ["b", { x: 10, y: 0 }]]);
const find = (node: string) => PLACES.get(node);

const atv = (of: Partial<AtvView>): AtvView => ({ id: "ATV1", status: "working", node: "a", way: ["b"], x_m: 0, y_m: 0, speed_mps: 0, ...of }) as AtvView;
const told = (atvs: AtvView[], obstacles: Partial<ObstacleView>[] = [], waits: string[] = []): Told => ({
  atvs: new Map(atvs.map((each) => [each.id, each])),
  obstacles: new Map(obstacles.map((each, index) => [String(index), each as ObstacleView])),
  waits: new Map(waits.map((id) => [id, {}])),
});

describe("how a door stands", () => {
  test("it is shut while nobody is there, or somebody is elsewhere", () => {
    expect(lookOf(DOOR, told([]), find)).toBe("shut");
    expect(lookOf(DOOR, told([atv({ node: "c", way: ["a", "b"] }), atv({ id: "ATV2", way: [] })]), find)).toBe("shut");
  });

  test("it opens for whoever stands before it, from either side, and for nobody who waits for another vehicle or was stopped", () => {
    expect(lookOf(DOOR, told([atv({})]), find)).toBe("opening");
    expect(lookOf(DOOR, told([atv({ node: "b", way: ["a"], x_m: 10 })]), find)).toBe("opening");
    expect(lookOf(DOOR, told([atv({})], [], ["ATV1"]), find)).toBe("shut");
    expect(lookOf(DOOR, told([atv({ status: "stopped" })]), find)).toBe("shut");
  });

  test("it is open as long as somebody is in it, whoever waits beside", () => {
    expect(lookOf(DOOR, told([atv({ x_m: 3, speed_mps: 1 })]), find)).toBe("open");
    expect(lookOf(DOOR, told([atv({ x_m: 5, status: "stopped" }), atv({ id: "ATV2", node: "b", way: ["a"], x_m: 10 })]), find)).toBe("open");
  });

  test("it has failed where vehicles have told so, in either direction", () => {
    expect(lookOf(DOOR, told([atv({})], [{ start: "b", end: "a" }]), find)).toBe("failed");
    expect(lookOf(DOOR, told([], [{ start: "b", end: "c" }]), find)).toBe("shut");
  });
});

const drawn = (told: Told, named = false, scale = 10) => {
  const lines: number[][] = [];
  const signs: number[][] = [];
  const words: unknown[][] = [];
  const draw = (x: number, y: number) => lines.push([x, y]);
  const nothing = () => undefined;
  const ctx = {
    beginPath: nothing, stroke: nothing, fill: nothing, strokeText: nothing, moveTo: draw, lineTo: draw, strokeStyle: "",
    arc: (...where: number[]) => signs.push(where), fillText: (...told: unknown[]) => words.push(told),
    measureText: (text: string) => ({ width: 8 * text.length }),
  };
  const view = { scale, x0: 0, y0: 0 } as unknown as Brush["view"];
  const brush = { ctx, view, palette: { ink: "ink", warn: "warn", alarm: "alarm", floor: "floor" } } as unknown as Brush;
  drawDoors(brush, { places: PLACES } as unknown as Roads, [DOOR], told, named, { things: [], words: [] });
  return { colour: ctx.strokeStyle, lines, signs, words };
};

test("a door is drawn across its lane: whole when it is shut, with a gap when it is open, and with a sign when it has failed", () => {
  const reach = (lines: number[][]) => Math.max(...lines.map(([, y]) => y ?? 0)) - Math.min(...lines.map(([, y]) => y ?? 0));
  const shut = drawn(told([]));
  expect(shut.colour).toBe("ink");
  expect(shut.lines).toHaveLength(4);
  expect(shut.lines[1]).toEqual(shut.lines[3]);
  expect(reach(shut.lines)).toBeCloseTo(16);
  const open = drawn(told([atv({ x_m: 5, speed_mps: 1 })]));
  expect(reach([open.lines[1] ?? [], open.lines[3] ?? []])).toBeCloseTo(0.6 * 16);
  expect(drawn(told([atv({})])).colour).toBe("warn");
  const failed = drawn(told([], [{ start: "a", end: "b" }]));
  expect([failed.colour, failed.lines.length, failed.words]).toEqual(["alarm", 8, []]);
  expect(failed.signs).toHaveLength(1);
  expect(shut.signs).toEqual([]);
});

test("a door that has failed says its name beyond its end, where names are shown", () => {
  expect(drawn(told([], [{ start: "a", end: "b" }]), true, 18).words).toEqual([["Gate", expect.any(Number), expect.any(Number)]]);
  expect(drawn(told([], [{ start: "a", end: "b" }]), true).words).toEqual([]);
  expect(drawn(told([]), true, 18).words).toEqual([]);
});
