import { describe, expect, it } from "vitest";
import { type Agent, barOf, type Figure, neighbour, shiftAt, shiftOf, shiftsAround, statesOf } from "./shifts";

const BEGINS = [
  { name: "early", begin_min: 360 },
  { name: "late", begin_min: 840 },
  { name: "night", begin_min: 1320 },
];
const at = (day: number, hour: number, minute = 0): number => new Date(2026, 10, day, hour, minute).getTime() / 1000;

describe("shifts", () => {
  it("are found by a moment, and a night shift lasts into the next day", () => {
    expect(shiftAt(BEGINS, at(19, 10))).toEqual({ name: "early", fromS: at(19, 6), untilS: at(19, 14) });
    expect(shiftAt(BEGINS, at(19, 14))).toMatchObject({ name: "late" });
    expect(shiftAt(BEGINS, at(19, 3))).toEqual({ name: "night", fromS: at(18, 22), untilS: at(19, 6) });
  });

  it("follow one another without a gap", () => {
    const all = shiftsAround(BEGINS, at(19, 10));
    for (const [i, each] of all.slice(0, -1).entries()) expect(each.untilS).toBe(all[i + 1]?.fromS);
  });

  it("of an address have their name, and a time of somebody's own has none", () => {
    const iso = (atS: number): string => new Date(atS * 1000).toISOString();
    expect(shiftOf(BEGINS, iso(at(19, 6)), iso(at(19, 14)), 0).name).toBe("early");
    expect(shiftOf(BEGINS, iso(at(19, 6)), iso(at(19, 15)), 0).name).toBe("");
    expect(shiftOf(BEGINS, "nonsense", undefined, at(19, 15)).name).toBe("late");
  });

  it("have neighbours of their own kind", () => {
    const early = shiftAt(BEGINS, at(19, 10));
    expect(neighbour(BEGINS, early, 1).name).toBe("late");
    expect(neighbour(BEGINS, early, -1)).toMatchObject({ name: "night", fromS: at(18, 22) });
    expect(neighbour(BEGINS, { name: "", fromS: 100, untilS: 160 }, -1)).toEqual({ name: "", fromS: 40, untilS: 100 });
  });
});

describe("a figure", () => {
  it("has a bar in which value and target keep their proportion", () => {
    const figure: Figure = { name: "x", unit: "count", better: "more", value: 50, before: 10, target: 100, missed: true };
    const bar = barOf(figure);
    expect((bar?.target ?? 0) / (bar?.value ?? 0)).toBeCloseTo(2);
    expect(barOf({ ...figure, before: null, target: null })).toBeNull();
    expect(barOf({ ...figure, value: null })).toBeNull();
  });
});

describe("states of SEMI E10", () => {
  const agent = (kind: string, doings_s: Record<string, number>): Agent => ({ agent: "A", kind, areas: [], doings_s, waits: 0 });

  it("are parts of an agent's time, and depend on what it is", () => {
    expect(statesOf(agent("machine", { makes: 30, blocked: 10 }))).toEqual({ productive: 0.75, standby: 0.25, scheduled: 0, unscheduled: 0 });
    expect(statesOf(agent("atv", { carries: 30, blocked: 10 }))).toMatchObject({ productive: 0.75, unscheduled: 0.25 });
    expect(statesOf(agent("atv", {})).productive).toBe(0);
  });
});
