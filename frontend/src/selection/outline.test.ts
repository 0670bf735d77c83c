import { expect, test } from "vitest";
import { MOST_CORNERS, NOTHING_DRAWN, shapeOf, withCorner } from "./outline";

const FLOOR = { width_m: 60, height_m: 40 };

test("two corners make a rectangle, more the shape that they are", () => {
  expect(shapeOf([[1, 2]])).toEqual([]);
  expect(shapeOf([[1, 2], [5, 9]])).toEqual([[1, 2], [5, 2], [5, 9], [1, 9]]);
  const triangle = [[1, 2], [5, 9], [0, 9]] as const;
  expect(shapeOf(triangle)).toBe(triangle);
});

test("a corner lies on the floor, to the centimetre, and there are no more than the gateway takes", () => {
  expect(withCorner(NOTHING_DRAWN, -3, 12.3456, FLOOR).corners).toEqual([[0, 12.35]]);
  let drawn = NOTHING_DRAWN;
  for (let i = 0; i < 20; i += 1) drawn = withCorner(drawn, i, 99, FLOOR);
  expect(drawn.corners).toHaveLength(MOST_CORNERS);
  expect(drawn.corners[0]).toEqual([0, 40]);
});
