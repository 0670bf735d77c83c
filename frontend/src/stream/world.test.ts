import { describe, expect, test } from "vitest";
import type { AtvView, Delta, FactoryView, Snapshot, StationView, TaskView } from "../api/types";
import { nothing } from "./nothing";
import { advance, worldOf } from "./world";

const factory = { speed: 1 } as FactoryView;
const atv = (id: string, battery_frac = 1) => ({ id, battery_frac }) as AtvView;

export const snapshot = (number: number, atvs: AtvView[] = []): Snapshot => ({
  ...nothing, type: "snapshot", number, at_s: 100, plant: "dray", factory, atvs, fault_injection: false, audience: null,
});
export const delta = (number: number, more: Partial<Delta> = {}): Delta => ({
  ...nothing, type: "delta", number, at_s: 101, factory: null, gone: [], ...more,
});

describe("a world", () => {
  test("takes what has changed of an entity, keeps the rest of it, and changes no earlier world", () => {
    const before = worldOf(snapshot(7, [{ ...atv("ATV1"), node: "n1" }, atv("ATV2")]));
    const after = advance(before, delta(8, { atvs: [{ id: "ATV1", battery_frac: 0.5 }, atv("ATV3", 0.2)] }));
    expect(after?.atvs.get("ATV1")).toEqual({ id: "ATV1", battery_frac: 0.5, node: "n1" });
    expect(after?.atvs.get("ATV3")?.battery_frac).toBe(0.2);
    expect(before.atvs.get("ATV1")?.battery_frac).toBe(1);
    expect(after?.atvs.get("ATV2")?.battery_frac).toBe(1);
    expect(after?.number).toBe(8);
  });

  test("is not to be had from a delta alone", () => {
    expect(advance(null, delta(1))).toBeNull();
  });

  test("ends at a gap, and at a number that comes twice", () => {
    const world = worldOf(snapshot(7));
    expect(advance(world, delta(9))).toBeNull();
    expect(advance(world, delta(7))).toBeNull();
  });

  test("is replaced by a snapshot of any number", () => {
    const after = advance(worldOf(snapshot(7, [atv("ATV1")])), snapshot(3, [atv("ATV2")]));
    expect([...(after?.atvs.keys() ?? [])]).toEqual(["ATV2"]);
  });

  test("loses what has gone, also where an id holds a colon, and ignores kinds it does not know", () => {
    const task = { id: "a:b" } as TaskView;
    const begun = advance(worldOf(snapshot(1)), delta(2, { tasks: [task] }));
    const after = advance(begun, delta(3, { gone: ["task:a:b", "ghost:x"] }));
    expect(begun?.tasks.size).toBe(1);
    expect(after?.tasks.size).toBe(0);
  });

  test("loses a fault that has ended, and keeps what was said about it", () => {
    const begun = advance(worldOf(snapshot(1)), delta(2, {
      faults: [{ id: "1" }], news: [{ id: "T1@2" }],
    }));
    const after = advance(begun, delta(3, { gone: ["fault:1"] }));
    expect([begun?.faults.size, after?.faults.size, after?.news.size]).toEqual([1, 0, 1]);
  });

  test("keeps what stations tell, until they have left", () => {
    const station = { id: "S1", stocks: [] } as unknown as StationView;
    const begun = advance(worldOf({ ...snapshot(1), stations: [station] }), delta(2, { stations: [{ ...station, id: "S2" }] }));
    expect([...(begun?.stations.keys() ?? [])]).toEqual(["S1", "S2"]);
    expect([...(advance(begun, delta(3, { gone: ["station:S1"] }))?.stations.keys() ?? [])]).toEqual(["S2"]);
  });

  test("keeps the very map of a kind that did not change", () => {
    const world = worldOf(snapshot(1, [atv("ATV1")]));
    expect(advance(world, delta(2))?.atvs).toBe(world.atvs);
    expect(advance(world, delta(2))?.factory).toBe(factory);
  });
});
