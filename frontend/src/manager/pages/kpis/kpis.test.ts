import { describe, expect, test } from "vitest";
import type { KpiHistory, KpiPoint } from "../../../api/types";
import type { Palette } from "../../../plant/draw/palette";
import { CHARTS } from "./charts";
import { stepFor } from "./charts/keys";
import { bandsOf, optionsOf } from "./charts/options";
import { shownValue } from "./charts/shown";
import { aloneIn, columnOf, lastOf, stacked, stepsOf, transportsPerHour } from "./history";

const point = (at_s: number, more: Partial<KpiPoint>): KpiPoint => ({ at_s, ...more }) as KpiPoint;
const history: KpiHistory = {
  since_at_s: 600,
  until_at_s: 1800,
  step_s: 300,
  items: [point(600, { moving_frac: 0.25, commands: 2 }), point(1200, { moving_frac: null, commands: 0 })],
};

describe("a column of the history", () => {
  test("has a place for every step and gaps where nothing was seen", () => {
    expect(stepsOf(history)).toEqual([600, 900, 1200, 1500]);
    expect(columnOf(history, "commands")).toEqual([2, null, 0, null]);
    expect(columnOf(history, "moving_frac")).toEqual([0.25, null, null, null]);
  });

  test("tells its newest figure, past the gaps", () => {
    expect(lastOf(columnOf(history, "commands"))).toBe(0);
    expect(lastOf([null, null])).toBeNull();
  });
});

test("a figure with none beside it is a dot, and one that a line leads to is none", () => {
  expect(aloneIn([null, 3, null])).toEqual([1]);
  expect(aloneIn([3])).toEqual([0]);
  expect(aloneIn([1, 2, null, 4])).toEqual([3]);
  expect(aloneIn([null, null])).toEqual([]);
  expect(aloneIn([1, null, 3], true)).toEqual([]);
  expect(aloneIn([null, 0, null], true)).toEqual([1]);
});

test("every chart draws a lone figure, whatever its kind", () => {
  for (const chart of CHARTS) {
    const drawn = optionsOf(chart, {} as Palette, { width: 1, height: 1 }, () => undefined);
    for (const { points } of drawn.series.slice(1)) {
      const data = [[0, 1], [null, 0.5]];
      expect(points?.filter).toBeInstanceOf(Function);
      expect((points?.filter as (plot: unknown, series: number, shown: boolean) => unknown)({ data }, 1, false)).toEqual([1]);
    }
  }
});

test("what was handed over is told per hour of all that was seen, not of the steps in which something was", () => {
  const items = [
    point(600, { span_s: 600, transports: 20, transports_per_hour: 120 }),
    point(900, { span_s: 600, transports: 0, transports_per_hour: 0 }),
    point(1200, { span_s: 300, transports: 5, transports_per_hour: 60 }),
  ];
  expect(transportsPerHour({ ...history, items })).toBe(60);
  expect(transportsPerHour({ ...history, items: [] })).toBeNull();
});

describe("a stack", () => {
  test("adds each part to those below it", () => {
    expect(stacked([[1, 2], [10, 20], [100, 200]])).toEqual([[1, 2], [11, 22], [111, 222]]);
  });

  test("has a gap wherever one of its parts is unknown", () => {
    expect(stacked([[1, 2], [null, 20], [100, 200]])).toEqual([[1, 2], [null, 22], [null, 222]]);
  });
});

describe("the charts", () => {
  test("draw no figure twice, and tell lines of one chart apart without colour", () => {
    const figures = CHARTS.flatMap(({ lines }) => lines.map(({ figure }) => figure));
    expect(new Set(figures).size).toBe(figures.length);
    for (const { kind, lines } of CHARTS) {
      if (kind !== "stack") expect(lines.filter(({ dashed }) => dashed !== true).length).toBeLessThanOrEqual(1);
    }
  });

  test("say a figure in its unit, and nothing of what nobody knows", () => {
    expect(shownValue({ unit: "percent" }, 0.974)).toBe("97.4\u202f%");
    expect(shownValue({ unit: "duration" }, 220)).toBe("3:40\u202fmin");
    expect(shownValue({ unit: "count" }, 1234.4)).toBe("1,234");
    expect(shownValue({ unit: "count" }, null)).toBe("–");
  });
});

describe("arrow keys", () => {
  test("begin at the newest step, stay inside, and let go with Escape", () => {
    expect(stepFor("ArrowLeft", null, 5)).toBe(4);
    expect(stepFor("ArrowLeft", 0, 5)).toBe(0);
    expect(stepFor("ArrowRight", 3, 5)).toBe(4);
    expect(stepFor("ArrowRight", 4, 5)).toBe(4);
    expect([stepFor("Home", 3, 5), stepFor("End", 3, 5)]).toEqual([0, 4]);
    expect(stepFor("Escape", 3, 5)).toBeNull();
    expect(stepFor("Tab", 3, 5)).toBeUndefined();
  });
});

test("each part of a stack is filled down to the next one alone, the last down to the axis", () => {
  const [stack, lines] = [CHARTS.find(({ kind }) => kind === "stack"), CHARTS.find(({ kind }) => kind === "lines")];
  expect(stack && bandsOf(stack).map(({ series }) => series)).toEqual([[1, 2], [2, 3], [3, 4], [4, 5], [5, 6]]);
  expect(lines && bandsOf(lines)).toEqual([]);
});
