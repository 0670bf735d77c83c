import { describe, expect, test } from "vitest";
import type { ClosureView } from "../../../api/types";
import { type Draft, DRAWN, requestOf as requestWith, warningsOf, whereText } from "./closure-text";

const requestOf = (asked: Draft) => requestWith(asked, []);

const draft: Draft = { what: "lane:c3>m5-lane", kind: "closed", speed: "0.5", until: "", reason: " oil " };

describe("a closure that is asked for", () => {
  test("names exactly one of lane, place and area", () => {
    expect(requestOf(draft)).toEqual({ kind: "closed", lane: { start: "c3", end: "m5-lane" }, reason: "oil" });
    expect(requestOf({ ...draft, what: "place:M5" })).toEqual({ kind: "closed", place: "M5", reason: "oil" });
    expect(requestOf({ ...draft, what: "area:AREA1" })).toEqual({ kind: "closed", area: "AREA1", reason: "oil" });
  });

  test("has a speed where it is slow, a direction where it is one-way, and an end if one is given", () => {
    expect(requestOf({ ...draft, kind: "slow" })).toMatchObject({ kind: "slow", speed_mps: 0.5 });
    expect(requestOf({ ...draft, kind: "one_way" })).toMatchObject({ kind: "one_way", lane: { start: "c3", end: "m5-lane" } });
    expect(requestOf({ ...draft, kind: "one_way_back" })).toMatchObject({ kind: "one_way", lane: { start: "m5-lane", end: "c3" } });
    expect(requestOf({ ...draft, until: "2030-01-01T02:00" })?.until).toMatch(/^20\d\d-.*Z$/);
  });

  test("has the corners of what is drawn, and is not sent before there is a shape", () => {
    const drawn = { ...draft, what: DRAWN };
    expect(requestWith(drawn, [[1, 2], [5, 2], [5, 9]])).toEqual({ kind: "closed", outline: [{ x_m: 1, y_m: 2 }, { x_m: 5, y_m: 2 }, { x_m: 5, y_m: 9 }], reason: "oil" });
    expect(requestOf(drawn)).toBeNull();
  });

  test("is not sent while something is missing", () => {
    for (const missing of [{ what: "" }, { reason: "  " }, { kind: "slow", speed: "" }, { kind: "slow", speed: "0" }, { kind: "one_way", what: "place:M5" }]) {
      expect(requestOf({ ...draft, ...missing } as Draft)).toBeNull();
    }
  });
});

test("what would be lost is said before, and nothing where nothing is", () => {
  expect(warningsOf({ cut_off: [], shut_in: [] })).toEqual([]);
  const [places, vehicles] = warningsOf({ cut_off: ["M5", "S3"], shut_in: ["ATV1"] });
  expect(places).toContain("M5, S3");
  expect(vehicles).toContain("ATV1");
});

test("an area is called by its name", () => {
  const closure = { lane: null, place: "", area: "AREA1", outline: [] as ClosureView["outline"] } as ClosureView;
  expect(whereText(closure, [{ id: "AREA1", name: "North" }])).toBe("North");
  expect(whereText({ ...closure, area: "", place: "M5" }, [])).toBe("M5");
});
