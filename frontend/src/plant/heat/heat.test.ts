import { describe, expect, test } from "vitest";
import type { Lane, LaneTraffic } from "../../api/types";
import { heatOf, stepOf, stepsTo } from "./heat";

const lane = (start: string, end: string): Lane => ({ start, end, both_ways: true, speed_limit_mps: 1.5, two_lanes: null, shape: [], types: [], original: null, original_back: null });

const driven = (start: string, end: string, passes: number, waits = 0, waited_s = 0): LaneTraffic => ({ start, end, passes, waits, waited_s });

describe("the heat of traffic", () => {
  test("is that of what was chosen", () => {
    const lanes = [driven("a", "b", 30, 2, 7.9), driven("b", "c", 10, 1, 0.5)];
    expect(heatOf(lanes, "waits").of(lane("a", "b"))).toBe(2);
    expect(heatOf(lanes, "waited_s").of(lane("b", "a"))).toBe(7.9);
    expect(heatOf(lanes, "waited_s").steps.at(-1)).toBeLessThanOrEqual(7);
    expect(heatOf([driven("b", "c", 10, 1, 0.5)], "waited_s").steps).toEqual([]);
  });

  test("is that of both directions together, whichever way a lane is named", () => {
    const heat = heatOf([driven("a", "b", 3), driven("b", "a", 4)], "passes");
    expect([heat.of(lane("a", "b")), heat.of(lane("b", "a")), heat.of(lane("b", "c"))]).toEqual([7, 7, 0]);
  });

  test("has no steps where nothing was passed, and no more than there are passes", () => {
    expect(heatOf([], "passes").steps).toEqual([]);
    expect(stepsTo(2)).toEqual([1, 2]);
    expect(stepsTo(50)).toEqual([1, 11, 21, 31, 41]);
  });

  test("has no two steps alike, however few passes there are", () => {
    for (let most = 1; most <= 60; most++) {
      const steps = stepsTo(most);
      expect([...new Set(steps)].sort((a, b) => a - b)).toEqual(steps);
      expect(steps[0]).toBe(1);
      expect(stepOf(most, steps)).toBe(steps.length);
    }
  });

  test("grows by steps up to the busiest lane", () => {
    const steps = stepsTo(50);
    expect([0, 1, 10, 11, 40, 41, 50].map((passes) => stepOf(passes, steps))).toEqual([0, 1, 1, 2, 4, 5, 5]);
  });
});
