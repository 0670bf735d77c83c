import { describe, expect, test } from "vitest";
import {
  boxOnScreen, centredOn, contains, fitView, isInSight, overlaps, scaleBar, toScreenX, toScreenY, wholeOf, zoomed,
} from "./geometry";

const floor = wholeOf({ width_m: 60, height_m: 40 });
const size = { width: 800, height: 600 };
const pad = { left: 10, right: 10, top: 50, bottom: 30 };
const fit = fitView(floor, size, pad);

describe("the fitted view", () => {
  test("holds the whole floor, centred between its margins", () => {
    expect(toScreenX(fit, 0)).toBeGreaterThanOrEqual(pad.left);
    expect(toScreenX(fit, 60)).toBeLessThanOrEqual(size.width - pad.right);
    expect(toScreenY(fit, 40)).toBeGreaterThanOrEqual(pad.top);
    expect(toScreenY(fit, 0)).toBeLessThanOrEqual(size.height - pad.bottom);
    expect(toScreenX(fit, 30)).toBeCloseTo(400);
  });

  test("has y pointing up", () => {
    expect(toScreenY(fit, 40)).toBeLessThan(toScreenY(fit, 0));
  });

  test("holds a part of the floor, wherever that lies", () => {
    const part = fitView({ left_m: 20, bottom_m: 12, width_m: 15, height_m: 7 }, size, pad);
    expect(toScreenX(part, 27.5)).toBeCloseTo(400);
    expect(toScreenX(part, 20)).toBeCloseTo(pad.left);
    expect(toScreenY(part, 19) - pad.top).toBeCloseTo(size.height - pad.bottom - toScreenY(part, 12));
  });

  test("survives a map without room", () => {
    expect(fitView(floor, { width: 0, height: 0 }, pad).scale).toBeGreaterThan(0);
  });
});

test("centring brings a point into the middle", () => {
  const view = zoomed(fit, centredOn(fit, size, { x: 5, y: 35 }, 4));
  expect(toScreenX(view, 5)).toBeCloseTo(400);
  expect(toScreenY(view, 35)).toBeCloseTo(300);
});

test("what is in sight is not looked for: the map stays", () => {
  const middle = { x: 5, y: 35 };
  const near = zoomed(fit, centredOn(fit, size, middle, 4));
  expect(isInSight(near, size, middle, 40)).toBe(true);
  expect(isInSight(near, size, { x: 55, y: 35 }, 40)).toBe(false);
  const edge = { x: (size.width - 10 - near.x0) / near.scale, y: 35 };
  expect(isInSight(near, size, edge, 0)).toBe(true);
  expect(isInSight(near, size, edge, 40)).toBe(false);
});

test("a box contains what lies in it, and near it with slack", () => {
  const rect = boxOnScreen(fit, { x_m: 30, y_m: 20, width_m: 6, depth_m: 4 });
  expect(contains(rect, toScreenX(fit, 32), toScreenY(fit, 21))).toBe(true);
  expect(contains(rect, rect.right + 2, rect.top)).toBe(false);
  expect(contains(rect, rect.right + 2, rect.top, 3)).toBe(true);
});

test("boxes that only touch do not overlap", () => {
  const a = { left: 0, top: 0, right: 10, bottom: 10 };
  expect(overlaps(a, { left: 10, top: 0, right: 20, bottom: 10 })).toBe(false);
  expect(overlaps(a, { left: 9, top: 9, right: 20, bottom: 20 })).toBe(true);
});

test.each([
  [12, 5],
  [1.1, 50],
  [200, 0.2],
])("the scale bar at %d px per metre shows %d m", (scale, metres) => {
  const bar = scaleBar(scale, 90);
  expect(bar.metres).toBeCloseTo(metres);
  expect(bar.px).toBeLessThanOrEqual(90);
});
