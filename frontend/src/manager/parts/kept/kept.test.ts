import { describe, expect, test } from "vitest";
import { earliestS, type Kept, reachOf } from "./kept";

const DAY_S = 86_400;
const NOW_S = 100 * DAY_S;

describe("a list that reaches back", () => {
  const kept = (more: Partial<Kept>): Kept => ({ kind: "events", days: 14, setting: "", since_at_s: NOW_S - 3 * DAY_S, gone_before_at_s: NOW_S - 14 * DAY_S, is_full: false, ...more });

  test("beyond what is kept says since when", () => {
    expect(reachOf(kept({}), NOW_S - 15 * DAY_S)).toEqual({ how: "gone", atS: NOW_S - 14 * DAY_S });
  });

  test("beyond the oldest that there is says so, though nothing was forgotten", () => {
    expect(reachOf(kept({}), NOW_S - 5 * DAY_S)).toEqual({ how: "begins", atS: NOW_S - 3 * DAY_S });
  });

  test("to what is there says nothing", () => {
    expect(reachOf(kept({}), NOW_S - 2 * DAY_S)).toBeNull();
    expect(reachOf(kept({ since_at_s: null, gone_before_at_s: null }), 0)).toBeNull();
  });
});

test("the earliest moment of a filter is its beginning, or its end where it has no other", () => {
  const at = (text: string): number => new Date(text).getTime() / 1000;
  expect(earliestS("2030-06-01T14:00", "2030-06-02T14:00")).toBe(at("2030-06-01T14:00"));
  expect(earliestS("", "2030-06-02T14:00")).toBe(at("2030-06-02T14:00"));
  expect(earliestS(undefined, "")).toBeNull();
});
