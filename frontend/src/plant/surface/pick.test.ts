import { expect, test } from "vitest";
import { pick, type Pickable } from "./pick";

/** One pixel per metre, origin top left of a 100 px high map. */
const view = { scale: 1, x0: 0, y0: 100 };
const machine: Pickable = { id: "M1", kind: "machine", box: { x_m: 50, y_m: 50, width_m: 30, depth_m: 20 } };
const at = (id: string, x: number, y: number) => ({ view: { id }, x, y });

test("a click chooses the nearest vehicle within reach", () => {
  const fleet = [at("ATV1", 10, 90), at("ATV2", 20, 90)];
  expect(pick(view, 17, 10, fleet, [])).toEqual({ kind: "atv", id: "ATV2" });
});

test("a vehicle is chosen before the machine that it stands at", () => {
  expect(pick(view, 50, 50, [at("ATV1", 52, 52)], [machine])).toEqual({ kind: "atv", id: "ATV1" });
});

test("a machine is chosen where no vehicle is near", () => {
  expect(pick(view, 40, 45, [at("ATV1", 90, 90)], [machine])).toEqual({ kind: "machine", id: "M1" });
});

test("a click on the bare floor chooses nothing", () => {
  expect(pick(view, 5, 5, [at("ATV1", 90, 10)], [machine])).toBeNull();
});
