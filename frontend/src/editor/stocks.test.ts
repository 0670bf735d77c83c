import { describe, expect, test } from "vitest";
import type { Data } from "./model";
import { keepable, stocksOf, warehousesOf, withChanged, withStock } from "./stocks";

const DATA: Data = {
  materials: [{ id: "shaft", lot: 40 }, { id: "bearing", lot: 20 }],
  products: [{ id: "pump", lot: 4 }, { id: "rotor", lot: 6, buffer: 12 }],
  warehouses: [
    { id: "SOURCE", kind: "source", node: "a", stocks: [{ material: "shaft", capacity: 4000 }] },
    { id: "SHUT", kind: "delivery", node: "a", stocks: [{ material: "shaft", capacity: 4000 }] },
    { id: "OPEN", kind: null, node: null, stocks: "shafts" },
  ],
};

describe("the stocks of a place", () => {
  test("are none where nobody has said any, and no list where something else was written", () => {
    expect([stocksOf(undefined), stocksOf(null), stocksOf([{ material: "shaft" }])]).toEqual([[], [], [{ material: "shaft" }]]);
    expect([stocksOf("shaft"), stocksOf([1]), stocksOf({})]).toEqual([null, null, null]);
  });

  test("are of materials and of parts, and one more is of what is not kept yet", () => {
    expect(keepable(DATA).map(({ id }) => id)).toEqual(["shaft", "bearing", "rotor"]);
    const two = withStock(DATA, withStock(DATA, []));
    expect(two).toEqual([{ material: "shaft", capacity: 400 }, { material: "bearing", capacity: 200 }]);
    const all = withStock(DATA, two);
    expect(withStock(DATA, all)).toBe(all);
  });

  test("leave out a point and a lot that are taken back, and keep a capacity that is open", () => {
    const one = withChanged([{ material: "shaft", capacity: 400 }], 0, { reorder_point: 120, lot: 40 });
    expect(one).toEqual([{ material: "shaft", capacity: 400, reorder_point: 120, lot: 40 }]);
    expect(withChanged(one, 0, { reorder_point: null, capacity: null })).toEqual([{ material: "shaft", capacity: null, lot: 40 }]);
  });
});

test("vehicles bring from source warehouses that keep it, and from no others", () => {
  expect([warehousesOf(DATA, "shaft"), warehousesOf(DATA, "bearing")]).toEqual([["SOURCE"], []]);
});
