import { describe, expect, test } from "vitest";
import type { AlertView, WaitView } from "../../api/types";
import { layersFrom, layersWith } from "../controls/layers";
import { hasTraffic, heldAhead, heldLine, jamsOf, waitLines } from "./held";

const PLACES = new Map(Object.entries({ a: { x: 0, y: 0 }, b: { x: 5, y: 0 }, c: { x: 9, y: 0 }, d: { x: 9, y: 4 } }));
const find = (id: string) => PLACES.get(id);

const wait = (id: string, chain: string[], more: Partial<WaitView> = {}): WaitView => ({
  id, since_at_s: 100, place: "", text: "", cause: { kind: "docked", chain, more: 0, place: "", since_at_s: null }, ...more,
});

describe("held places", () => {
  test("tell that there is right of way", () => {
    expect([hasTraffic([]), hasTraffic([{ holds: [] }]), hasTraffic([{ holds: [] }, { holds: ["a"] }])]).toEqual([false, false, true]);
  });

  test("lead as far as the last node of the way that is held, whatever lies in crossings before it", () => {
    expect(heldAhead({ holds: ["a"], way: ["b", "c"] })).toBe(0);
    expect(heldAhead({ holds: ["a", "b"], way: ["b", "c"] })).toBe(1);
    expect(heldAhead({ holds: ["crossing", "c"], way: ["b", "c", "d"] })).toBe(2);
  });

  test("begin with what lies behind the vehicle", () => {
    const here = { x: 6, y: 0 };
    expect(heldLine({ holds: ["a", "b", "c"], node: "b", way: ["c", "d"] }, [here], find)).toEqual([PLACES.get("a"), PLACES.get("b"), here]);
    expect(heldLine({ holds: ["crossing", "c"], node: "b", way: ["c"] }, [here], find)).toEqual([here]);
    expect(heldLine({ holds: [], node: "b", way: ["c"] }, [here], find)).toEqual([here]);
  });
});

describe("waits", () => {
  test("are lines to whom each waits for, and those of the chosen one's chain are chosen", () => {
    const lines = waitLines([wait("a", ["b", "c"]), wait("b", ["c"]), wait("d", ["c"])], find, "a");
    expect(lines.map(({ chosen }) => chosen)).toEqual([true, true, false]);
    expect(lines[0]).toMatchObject({ from: PLACES.get("a"), to: PLACES.get("b") });
  });

  test("for nobody, or for one that is not seen, are no lines", () => {
    expect(waitLines([wait("a", []), wait("b", ["*"])], find, null)).toEqual([]);
  });
});

describe("a jam", () => {
  const alert = { kind: "jam", agents: ["a", "b", "*"], since_at_s: 150 } as AlertView;

  test("has all that are seen of it, and lasts since the first one has waited", () => {
    const waits = new Map([["a", wait("a", ["c"], { since_at_s: 120 })], ["b", wait("b", ["x"], { since_at_s: 110 })]]);
    const [jam] = jamsOf([alert, { ...alert, kind: "atv_waits" }], waits, find);
    expect(jam?.lines).toEqual([{ from: PLACES.get("a"), to: PLACES.get("c") }, { from: PLACES.get("b"), to: PLACES.get("b") }]);
    expect(jam?.sinceAtS).toBe(110);
  });

  test("of which nobody is seen is not drawn", () => {
    expect(jamsOf([{ ...alert, agents: ["*"] }], new Map(), find)).toEqual([]);
  });
});

describe("the layer of right of way", () => {
  test("can be chosen where there is any, and is shown at first", () => {
    expect([layersWith(true).includes("traffic"), layersWith(false).includes("traffic")]).toEqual([true, false]);
    expect(layersFrom(null).traffic).toBe(true);
  });
});
