import { expect, test } from "vitest";
import type { Area, PlantFile } from "../../api/types";
import type { Rect } from "../surface/geometry";
import type { Brush } from "./brush";
import { areaNames } from "./floor";

/** Ten pixels of a metre, the floor's origin at (0, 1000), and letters of eight pixels. */
const brush = {
  ctx: { measureText: (text: string) => ({ width: 8 * text.length }) },
  view: { scale: 10, x0: 0, y0: 1000 },
  palette: { font: "sans-serif" },
} as unknown as Brush;

const area = (name: string, ...corners: [number, number][]): Area =>
  ({ id: name, name, polygon: corners.map(([x_m, y_m]) => ({ x_m, y_m })) }) as Area;
const names = (areas: Area[], machines: unknown[] = [], signs: Rect[] = []) =>
  areaNames(brush, { areas, machines, storages: [], warehouses: [] } as unknown as PlantFile, signs).map(({ name, rect }) => ({ name, left: rect.left, top: rect.top }));
const box = (x_m: number, y_m: number, width_m = 4) => ({ box: { x_m, y_m, width_m, depth_m: 4 } });

test("a name stands in the lower left corner of its area", () => {
  expect(names([area("North", [0, 0], [40, 0], [40, 30], [0, 30])])).toEqual([{ name: "North", left: 8, top: 985 }]);
});

test("where a machine stands there, it stands in the next corner", () => {
  expect(names([area("North", [0, 0], [40, 0], [40, 30], [0, 30])], [box(2, 2)])).toEqual([{ name: "North", left: 352, top: 985 }]);
});

test("where something was met on a lane, it keeps clear of the sign", () => {
  const sign = { left: 20, right: 40, top: 980, bottom: 1000 };
  expect(names([area("North", [0, 0], [40, 0], [40, 30], [0, 30])], [], [sign])[0]?.left).toBe(352);
});

test("on a map that has no room for it, it has no name: it would stand in another one", () => {
  const all = { left: 0, right: 400, top: 700, bottom: 1000 };
  expect(names([area("North", [0, 0], [40, 0], [40, 30], [0, 30])], [], [all])).toEqual([]);
});

test("in an area that has no lower left corner it stands in another one, and not beside the area", () => {
  const bent = area("Bent", [20, 0], [40, 0], [40, 30], [0, 30], [0, 15], [20, 15]);
  expect(names([bent])).toEqual([{ name: "Bent", left: 360, top: 985 }]);
});

test("a name wider than its area does not begin in the one to the left", () => {
  const narrow = area("A long name", [40, 0], [46, 0], [46, 30], [40, 30]);
  expect(names([narrow], [box(46, 2, 1)])[0]?.left).toBe(408);
});

test("two areas that lie over one another have their names in two places", () => {
  const both = ["One", "Two"].map((name) => area(name, [0, 0], [40, 0], [40, 30], [0, 30]));
  expect(names(both).map(({ left }) => left)).toEqual([8, 368]);
});
