import { describe, expect, test } from "vitest";
import type { AtvView, TaskView } from "../api/types";
import { detailOf } from "./draw/detail";
import { lookOf, shortName } from "./draw/vehicles";
import { layersFrom, layersWith } from "./controls/layers";
import { meshLinks, watchLinks } from "./surface/links";
import { find, type Findable } from "./places";
import { boundS, isLost, isOverdue } from "./silence";
import { filledFrac, isLow } from "./stock";

describe("a buffer", () => {
  test("below its reorder point is well as long as a delivery is on order", () => {
    expect(isLow({ level: 10, reorder_point: 20, on_order: 24 })).toBe(false);
    expect(isLow({ level: 10, reorder_point: 20, on_order: 0 })).toBe(true);
  });

  test("that is empty is low whatever is on order", () => {
    expect(isLow({ level: 0, reorder_point: 20, on_order: 24 })).toBe(true);
  });

  test("is never drawn fuller than full", () => {
    expect(filledFrac({ level: 30, capacity: 20 })).toBe(1);
    expect(filledFrac({ level: 3, capacity: 0 })).toBe(0);
  });
});

describe("silence", () => {
  const seen = { seen_at_s: 90, shut_out: null, silence: { beat_s: 1, overdue_after_s: 2, lost_after_s: 7 } };

  test("means what the gateway tells that it means", () => {
    expect([isOverdue(seen, 91.9, 1), isOverdue(seen, 92.1, 1)]).toEqual([false, true]);
    expect([isLost(seen, 96.9, 1), isLost(seen, 97.1, 1)]).toEqual([false, true]);
    expect(isLost(seen, 90.1 + boundS(seen, 1), 1)).toBe(true);
  });

  test("is told in factory seconds", () => {
    expect([isOverdue(seen, 90.9, 2), isOverdue(seen, 91.1, 2)]).toEqual([false, true]);
    expect([isLost(seen, 93.4, 2), isLost(seen, 93.6, 2)]).toEqual([false, true]);
  });

  test("of whoever is shut out is there at once", () => {
    const by = { by: "Ada", reason: "lies", at_s: 90 };
    expect(isLost({ ...seen, shut_out: by }, 90, 1)).toBe(true);
  });
});

describe("the look of a vehicle", () => {
  const atv = (more: object) => ({ status: "working", ...more }) as AtvView;

  test("is silent before all else: what it said last is a memory", () => {
    expect(lookOf(atv({ status: "error" }), true, true)).toBe("lost");
    expect(lookOf(atv({ status: "error" }), true, false)).toBe("alarm");
    expect(lookOf(atv({}), true, false)).toBe("chosen");
  });
});

describe("detail", () => {
  test("falls away with the zoom until vehicles are dots", () => {
    expect(detailOf(12, 8)).toMatchObject({ vehicleParts: true, vehicleLabels: true, everybody: true });
    expect(detailOf(2, 1000)).toMatchObject({ vehicleParts: false, vehicleLabels: false, everybody: false });
  });

  test("has lines of the chosen alone where many are in sight, and of everybody for who wishes", () => {
    expect([detailOf(12, 30).everybody, detailOf(12, 31).everybody, detailOf(12, 50, true).everybody]).toEqual([true, false, true]);
    expect(detailOf(12, 50)).toMatchObject({ vehicleParts: true, vehicleLabels: true });
    expect([layersWith(true).includes("all"), layersWith(true, true).includes("all")]).toEqual([false, true]);
    expect(layersFrom(null).all).toBe(false);
  });
});

describe("links", () => {
  const places: Record<string, { x: number; y: number }> = {
    ATV1: { x: 1, y: 1 }, ATV2: { x: 2, y: 2 }, M1: { x: 3, y: 3 },
  };
  const task = {
    kind: "transport", state: "contracted", coordinator: "M1", primary: "ATV1", secondary: "ATV2",
  } as TaskView;
  const where = (id: string) => places[id];

  test("join carrier and machine, watcher and carrier", () => {
    const links = watchLinks([task], where, null);
    expect(links.primary).toEqual([{ from: places.ATV1, to: places.M1 }]);
    expect(links.secondary).toEqual([{ from: places.ATV2, to: places.ATV1, guarded: "ATV1" }]);
  });

  test("of others are left out where only the chosen are asked for", () => {
    expect(watchLinks([task], where, { atv: "ATV9", machine: null }).primary).toEqual([]);
    expect(watchLinks([task], where, { atv: "ATV1", machine: null }).primary).toHaveLength(1);
    expect(watchLinks([task], where, { atv: null, machine: "M1" }).secondary).toHaveLength(1);
  });

  test("of a watcher show whom it watches, and not for whom that one drives", () => {
    const { primary, secondary } = watchLinks([task], where, { atv: "ATV2", machine: null });
    expect([primary.length, secondary.length]).toEqual([0, 1]);
  });

  test("through the mesh lead along the vehicles that relay", () => {
    const speaking = { x: 9, y: 9, view: { link: "mesh", via: ["ATV2", "ATV1"] } };
    const ends = meshLinks([speaking], where).map((line) => line.to);
    expect(ends).toEqual([places.ATV2, places.ATV1]);
    expect(meshLinks([{ ...speaking, view: { link: "wlan", via: [] } }], where)).toEqual([]);
  });
});

describe("a vehicle's name", () => {
  test("a long name keeps its beginning and its end", () => {
    expect(shortName("ATV1")).toBe("ATV1");
    expect(shortName("FOURTEEN-CHARS")).toBe("FOURTEEN-CHARS");
    expect(shortName("AUTONOMOUS-TRANSPORT-VEHICLE-0017")).toBe("AUTONOMO…-0017");
  });
});

describe("finding", () => {
  const thing = (id: string, name: string): Findable => ({ chosen: { kind: "machine", id }, id, name });
  const all = [thing("M1", "Gear press"), thing("M10", "Motor cell"), thing("S1", "Storage S1")];

  test("prefers names that begin with the words", () => {
    expect(find([thing("XM1", ""), ...all], "m1", 9).map(({ id }) => id)).toEqual(["M1", "M10", "XM1"]);
  });

  test("looks into the long name, and gives no more than asked for", () => {
    expect(find(all, "motor", 9).map(({ id }) => id)).toEqual(["M10"]);
    expect(find(all, "", 2)).toHaveLength(2);
  });
});

test("layers are remembered by name; unknown ones are nobody's", () => {
  expect(layersFrom("areas nonsense")).toMatchObject({ areas: true, ways: false });
  expect(layersFrom(null)).toMatchObject({ areas: false, ways: true });
});
