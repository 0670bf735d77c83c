import { describe, expect, test } from "vitest";
import type { Area } from "../../api/types";
import { areaAt, distanceM, regionOf } from "./region";

const area = (id: string, ...corners: [number, number][]): Area => ({
  id, name: id, working_time: null, polygon: corners.map(([x_m, y_m]) => ({ x_m, y_m })),
});
const south = area("S", [0, 0], [60, 0], [60, 12], [0, 12]);
const corner = area("C", [60, 0], [80, 0], [80, 30], [70, 30], [70, 12], [60, 12]);

describe("the part of the floor that is shown", () => {
  test("holds all areas", () => {
    expect(regionOf([south, corner])).toEqual({ left_m: 0, bottom_m: 0, width_m: 80, height_m: 30 });
  });

  test("is the whole plant where there are no areas", () => {
    expect(regionOf([])).toBeNull();
  });
});

test.each([[30, 6, "S"], [75, 25, "C"], [65, 25, undefined], [-1, 5, undefined]])("at (%d, %d) is area %s", (x, y, id) => {
  expect(areaAt([south, corner], x, y)?.id).toBe(id);
});

test("distance is counted from the machine's middle", () => {
  expect(distanceM({ box: { x_m: 3, y_m: 4, width_m: 2, depth_m: 2 } }, { x_m: 0, y_m: 0 })).toBe(5);
});
