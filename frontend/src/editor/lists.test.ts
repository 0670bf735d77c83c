import { describe, expect, test } from "vitest";
import { calledOf, COLUMNS, linesOf, REFERS, rowOf, rowsOf, together, valueOf, withRow, withValue, writtenOf, type Column } from "./lists";

const DATA = {
  nodes: [{ id: "n1", x_m: 0, y_m: 0 }, { id: "n2", x_m: 1, y_m: 0 }],
  materials: [{ id: "shaft", name: "Shaft", lot: 10, buffer: 30 }],
  products: [{ id: "gear", name: "Gear", lot: 5, buffer: 20, bill: [] }, { id: "pump", name: "Pump", lot: 5, bill: [] }],
  vehicle_types: [{ id: "light", name: "Light" }],
  fleet: [{ id: "ATV1", type: "light", node: "n1" }],
};

const column = (section: string, name: string): Column => {
  const found = COLUMNS[section]?.find((each) => each.name === name);
  if (!found) throw new Error(name);
  return found;
};

describe("lists of the plant file as forms", () => {
  test("what nobody has said are no rows, and what is no list is none", () => {
    expect(rowsOf(null)).toEqual([]);
    expect(rowsOf(undefined)).toEqual([]);
    expect(rowsOf([{ id: "a" }])).toEqual([{ id: "a" }]);
    expect(rowsOf("gears")).toBeNull();
    expect(rowsOf([null])).toBeNull();
  });

  test("a new vehicle has a free id, a type that there is, and a node where no other begins", () => {
    const rows = withRow(DATA, COLUMNS.fleet ?? [], DATA.fleet, "ATV");
    expect(rows.at(-1)).toEqual({ id: "ATV2", type: "light", node: "n2" });
  });

  test("a new product has an open lot and an empty bill; a bill names materials and parts, and no product for customers", () => {
    expect(withRow(DATA, COLUMNS.products ?? [], [], "product")).toEqual([{ id: "product1", name: null, lot: null, bill: [] }]);
    expect(column("products", "bill").columns?.[0]?.from?.(DATA)).toEqual(["shaft", "gear"]);
  });

  test("what is optional and left empty is not in the file; what has to be said is open", () => {
    const row = { id: "gear", name: "Gear", lot: 5, buffer: 20 };
    expect(withValue(row, column("products", "buffer"), undefined)).toEqual({ id: "gear", name: "Gear", lot: 5 });
    expect(withValue(row, column("products", "lot"), undefined)).toEqual({ id: "gear", name: "Gear", lot: null, buffer: 20 });
    expect(withValue(row, column("products", "lot"), 7)).toEqual({ id: "gear", name: "Gear", lot: 7, buffer: 20 });
  });

  test("a number is read with a point or a comma, and what is none is left to the checks", () => {
    expect(valueOf(column("fleet", "battery_frac"), "0,8")).toBe(0.8);
    expect(valueOf(column("fleet", "battery_frac"), "0.8")).toBe(0.8);
    expect(valueOf(column("materials", "lot"), "many")).toBe("many");
    expect(valueOf(column("materials", "lot"), " ")).toBeUndefined();
    expect(valueOf(column("vehicle_types", "abilities"), "tote, pallet")).toEqual(["tote", "pallet"]);
  });

  test("what names a node or a working station is chosen of those that there are", () => {
    expect(REFERS.node?.(DATA)).toEqual(["n1", "n2"]);
    expect(REFERS.station?.({ stations: [{ id: "turning" }, null, { id: 3 }] })).toEqual(["turning"]);
    expect(REFERS.station?.({ stations: null })).toEqual([]);
  });

  test("a new shift is of the days of the week from six to two; a time that is taken away is open", () => {
    const shifts = column("working_time", "shifts").columns ?? [];
    const end = shifts.find(({ name }) => name === "end");
    if (!end) throw new Error("end");
    const rows = withRow(DATA, shifts, [], "");
    expect(rows).toEqual([{ start: "06:00", end: "14:00", days: ["mon", "tue", "wed", "thu", "fri"] }]);
    expect(withValue(rows[0] ?? {}, end, undefined)).toEqual({ ...rows[0], end: null });
  });

  test("what stands together is not in the file once all of it is empty", () => {
    const size = COLUMNS.max_vehicle ?? [];
    expect(together(size, { length_m: 1.2, width_m: null })).toEqual({ length_m: 1.2, width_m: null });
    expect(together(size, { length_m: null, width_m: null })).toBeUndefined();
    expect(together(COLUMNS.working_time ?? [], { shifts: [] })).toBeUndefined();
    expect(rowOf(undefined)).toEqual({});
    expect(rowOf("always")).toBeNull();
  });

  test("names of vehicles stand one a line, with their spaces", () => {
    expect(valueOf(column("originals", "originals"), "Dock 4\n\n  N-17 ")).toEqual(["Dock 4", "N-17"]);
    expect(linesOf(["Dock 4"])).toEqual(["Dock 4"]);
    expect(linesOf([4])).toBeNull();
  });

  test("a row is called by what tells it from others", () => {
    expect(calledOf(COLUMNS.lanes ?? [], { start: "n1", end: "n2" })).toBe("n1 – n2");
    expect(calledOf(COLUMNS.polygon ?? [], { x_m: 0, y_m: 4 })).toBe("0 – 4");
    expect(calledOf(COLUMNS.makes ?? [], { product: "gear", cycle_s: 4 })).toBe("gear");
  });

  test("nothing is shown for what is open", () => {
    expect(writtenOf(null)).toBe("");
    expect(writtenOf(undefined)).toBe("");
    expect(writtenOf(3)).toBe("3");
    expect(writtenOf(["tote", "pallet"])).toBe("tote, pallet");
  });
});
