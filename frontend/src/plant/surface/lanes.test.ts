import { describe, expect, test } from "vitest";
import type { PlantFile } from "../../api/types";
import { laneId, laneOf, pickLane, roadOf } from "./lanes";

const plant = {
  nodes: [{ id: "a", x_m: 0, y_m: 0 }, { id: "b", x_m: 10, y_m: 0 }, { id: "c", x_m: 10, y_m: 10 }],
  lanes: [{ start: "a", end: "b" }, { start: "b", end: "c" }],
} as PlantFile;
/** Ten pixels per metre, y upwards, the origin at (0, 200). */
const view = { scale: 10, x0: 0, y0: 200 };

describe("a lane", () => {
  test("is named by its ends", () => {
    expect(laneOf(laneId({ start: "b1.to-c1", end: "c1.from-b1" }))).toEqual({ start: "b1.to-c1", end: "c1.from-b1" });
    expect(laneOf("M5")).toBeNull();
  });

  test("is chosen by a click near it, and the nearer one at a corner", () => {
    const at = (x_m: number, y_m: number) => pickLane(view, plant, view.x0 + 10 * x_m, view.y0 - 10 * y_m);
    expect(at(5, 0.5)).toBe("a>b");
    expect(at(10.3, 6)).toBe("b>c");
    expect(at(5, 3)).toBeNull();
  });
});

test("a lane of a two-lane road is called as the road was drawn, and any other lane as it is", () => {
  expect(roadOf({ start: "m8-lane.to-c2", end: "c2.from-m8-lane" })).toEqual({ start: "m8-lane", end: "c2" });
  expect(roadOf({ start: "a.to-b", end: "c.from-a" })).toEqual({ start: "a.to-b", end: "c.from-a" });
  expect(roadOf({ start: "a", end: "b" })).toEqual({ start: "a", end: "b" });
});
