import { describe, expect, test } from "vitest";
import { dueOnBand, type Estimate, heightOf, labelsOf, leftOf, linesOf, movesOf, stepsOf, timeOf, topOf } from "./estimates";
import { moveText, stayedText } from "./EstimatesCard";

const at = (atS: number, fromS: number | null, toS: number | null, more: Partial<Estimate> = {}): Estimate => ({
  at_s: atS, from_at_s: fromS, to_at_s: toS, cause: "later", agent: "", other: "", ...more,
});

const MOVED = [
  at(0, 1000, 1300, { cause: "first" }),
  at(100, 1050, 1250, { cause: "closer" }),
  at(200, 1400, 1700, { cause: "replaced", agent: "ATV3", other: "ATV1" }),
  at(300, null, null, { cause: "stands", agent: "M4" }),
  at(400, 1500, 1600, { cause: "again" }),
];

describe("the estimates of an order", () => {
  test("have a move for each that people want to know the cause of", () => {
    expect(movesOf(MOVED).map(({ byS, estimate }) => [estimate.cause, byS])).toEqual([["replaced", 450], ["stands", null], ["again", null]]);
  });

  test("are drawn as long as each was told, with a gap where nothing could be", () => {
    const time = timeOf(MOVED, 500, false);
    const height = heightOf(MOVED, [1350, null]);
    expect([time.fromS, time.toS]).toEqual([0, 500]);
    const steps = stepsOf(MOVED, time, height, 500);
    expect(steps.map(({ leftPercent, widthPercent }) => [leftPercent, widthPercent])).toEqual([[0, 20], [20, 20], [40, 20], [80, 20]]);
    for (const { heightPercent, topPercent } of steps) {
      expect(topPercent).toBeGreaterThan(0);
      expect(topPercent + heightPercent).toBeLessThan(100);
    }
  });

  test("are higher the later they are", () => {
    const span = { fromS: 0, toS: 100 };
    expect(leftOf(span, 25)).toBe(25);
    expect(topOf(span, 25)).toBe(75);
  });
});

describe("a move says its cause by name, and by how much", () => {
  test("later, sooner, and where nobody can tell", () => {
    const [replaced, stands, again] = movesOf(MOVED).map(moveText);
    expect(replaced).toMatch(/^ATV1 carries on for ATV3: .*later$/);
    expect(stands).toBe("M4 stands: nobody can tell when");
    expect(again).toBe("It can be told again");
    expect(moveText({ estimate: at(0, 1, 2, { cause: "sooner" }), byS: -120 })).toMatch(/sooner$/);
  });
});

test("an estimate that has moved too little to be kept is told as it is now", () => {
  const kept = [at(0, 1000, 1300, { cause: "first" }), at(100, 1050, 1250, { cause: "closer" })];
  expect(stayedText(kept, { from_at_s: 1050, to_at_s: 1250 })).toBe("It has not moved since it was first told.");
  expect(stayedText(kept, null)).toBe("It has not moved since it was first told.");
  expect(stayedText(kept, { from_at_s: 1050, to_at_s: 1310 })).toMatch(/^It has changed little since the first estimate\. Now expected: .+ to .+\.$/);
});

describe("the numbers of moves", () => {
  test("stand on one line where there is room, else above one another", () => {
    expect(linesOf([0, 20, 40])).toEqual([0, 0, 0]);
    expect(linesOf([0, 2, 9, 11, 50])).toEqual([0, 1, 0, 1, 0]);
  });

  test("are left out where more stand in one place than there are lines", () => {
    expect(linesOf([10, 11, 12, 13, 18])).toEqual([0, 1, 2, null, 0]);
  });
});

test("the drawing of an order that has ended leaves out a due time that was never in doubt", () => {
  const told = [at(100, 140, 150)];
  expect(dueOnBand(told, 4000, 145, true)).toBeNull();
  expect(dueOnBand(told, 148, 145, true)).toBe(148);
  expect(dueOnBand(told, 4000, null, false)).toBe(4000);
});

test("the drawing of an order that has ended ends with it", () => {
  expect(timeOf([at(100, 140, 150)], 120, true)).toEqual({ fromS: 100, toS: 120 });
  expect(timeOf([at(100, 140, 150)], 120, false)).toEqual({ fromS: 100, toS: 160 });
});

describe("the times beside the drawing", () => {
  const height = { fromS: 0, toS: 1000 };

  test("stand where they belong, if there is room between them", () => {
    expect(labelsOf([200, 600], height)).toEqual([{ atS: 200, topPercent: 80 }, { atS: 600, topPercent: 40 }]);
  });

  test("stand apart, the later above, where there is none", () => {
    const [earlier, later] = labelsOf([200, 210], height);
    expect((earlier?.topPercent ?? 0) - (later?.topPercent ?? 0)).toBeCloseTo(13);
  });

  test("are one where both are the same, and none where nothing is known", () => {
    expect(labelsOf([200, 200], height)).toEqual([{ atS: 200, topPercent: 80 }]);
    expect(labelsOf([], height)).toEqual([]);
  });
});
