import { describe, expect, test } from "vitest";
import type { PromiseLine } from "../../../api/types";
import { AT_FIRST, next, sorted } from "./ledger";

const line = (atv: string, p95_s: number | null, more: Partial<PromiseLine> = {}): PromiseLine => ({
  atv, delivered: 10, on_time: 9, on_time_frac: p95_s === null ? null : 0.9, median_s: p95_s, p95_s, worst_s: p95_s,
  worst_task: "", worst_held: "", worst_held_by: "", lost: 0, last_at_s: null, ...more,
});
const order = (lines: PromiseLine[], by: Parameters<typeof sorted>[1]): string[] => sorted(lines, by).map(({ atv }) => atv);

describe("the ledger", () => {
  const lines = [line("ATV10", 3), line("ATV2", null), line("ATV3", 40), line("ATV1", 3)];

  test("begins with whoever keeps its promises worst", () => {
    expect(order(lines, AT_FIRST)).toEqual(["ATV3", "ATV1", "ATV10", "ATV2"]);
  });

  test("has what nobody knows at the end, whichever way it is sorted", () => {
    expect(order(lines, { column: "p95", descending: false })).toEqual(["ATV1", "ATV10", "ATV3", "ATV2"]);
  });

  test("sorts vehicles by number, not by letter", () => {
    expect(order(lines, { column: "vehicle", descending: false })).toEqual(["ATV1", "ATV2", "ATV3", "ATV10"]);
    expect(order(lines, { column: "vehicle", descending: true })[0]).toBe("ATV10");
  });

  test("turns round with a second click, and begins with the interesting end of another column", () => {
    expect(next(AT_FIRST, "p95")).toEqual({ column: "p95", descending: false });
    expect(next(AT_FIRST, "lost")).toEqual({ column: "lost", descending: true });
    expect(next(AT_FIRST, "onTime")).toEqual({ column: "onTime", descending: false });
  });
});
