import { describe, expect, test } from "vitest";
import type { NewsView } from "../../api/types";
import { markLook, Marks } from "./marks";

const took = (more: Partial<NewsView> = {}) =>
  ({ id: "T@2", kind: "took_over", agent: "ATV1", other: "ATV3", ...more }) as NewsView;

describe("the mark of a takeover", () => {
  test("sends waves, then leaves the line alone, then is gone", () => {
    expect(markLook(0.7, true)?.wave?.px).toBeGreaterThan(0);
    expect(markLook(5, true)).toEqual({ wave: null, lineAlpha: 1 });
    expect(markLook(7, true)).toBeNull();
    expect(markLook(-1, true)).toBeNull();
  });

  test("is one still ring for who wants no motion", () => {
    expect(markLook(0.2, false)?.wave?.px).toBe(markLook(5, false)?.wave?.px);
  });

  test("goes from the one that failed to the one that carries on", () => {
    const marks = new Marks();
    marks.observe([took()], 1000);
    expect(marks.shown(2000, true)).toMatchObject([{ from: "ATV3", to: "ATV1" }]);
    expect(marks.shown(9000, true)).toEqual([]);
  });

  test("does not begin again when the takeover is confirmed", () => {
    const marks = new Marks();
    marks.observe([took({ confirmed: false })], 1000);
    marks.observe([took()], 9000);
    expect(marks.shown(9000, true)).toEqual([]);
  });

  test("is taken away when the takeover is refused", () => {
    const marks = new Marks();
    marks.observe([took()], 1000);
    marks.observe([took({ kind: "takeover_refused" })], 1500);
    expect(marks.shown(1600, true)).toEqual([]);
  });

  test("is not kept for ever", () => {
    const marks = new Marks();
    for (let i = 0; i < 200; i += 1) marks.observe([took({ id: `${i}` })], 1000);
    expect(marks.shown(1000, true).length).toBeLessThanOrEqual(50);
  });
});
