import { describe, expect, test } from "vitest";
import { delayS, nextMoment } from "./playback";

test("who speaks seldom is shown later, and a fast factory with less delay", () => {
  expect(delayS(5, 1)).toBeGreaterThan(delayS(1, 1));
  expect(delayS(1, 1)).toBeGreaterThan(1);
  expect(delayS(1, 50)).toBeLessThan(0.5);
});

describe("the shown moment", () => {
  test("runs with the clock", () => {
    expect(nextMoment(98, 98.016, 0.016, false)).toBeCloseTo(98.016);
  });

  test("slows down for a longer delay and hurries for a shorter one, but never turns back", () => {
    for (const wanted of [-4, 4]) {
      let at = 100;
      for (let now = 0.02; now < 20; now += 0.02) {
        const next = nextMoment(at, 100 + wanted + now, 0.02, false);
        expect(next).toBeGreaterThan(at);
        at = next;
      }
      expect(at).toBeCloseTo(100 + wanted + 20, 1);
    }
  });

  test("makes no leap when the server's clock is known better", () => {
    expect(nextMoment(100, 100.06, 0.01, false)).toBeLessThan(100.02);
  });

  test("of a vehicle at rest is right at once, and waits where it was ahead", () => {
    expect(nextMoment(100, 104, 0.02, true)).toBe(104);
    expect(nextMoment(100, 96, 0.02, true)).toBe(100);
  });

  test("begins anew after a long absence", () => {
    expect(nextMoment(100, 500, 0.02, false)).toBe(500);
  });
});
