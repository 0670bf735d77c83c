import { expect, test } from "vitest";
import { delayS, Playback } from "./playback";

test("a fast factory is shown with less delay, because its news comes oftener", () => {
  expect(delayS(50)).toBeLessThan(delayS(1));
  expect(delayS(1)).toBeGreaterThan(1);
});

test("playback runs evenly with the server's clock", () => {
  const playback = new Playback();
  expect(playback.at(0, 100, 1.2)).toBeCloseTo(98.8);
  expect(playback.at(0.016, 100.016, 1.2)).toBeCloseTo(98.816);
});

test("a longer delay slows playback down, but never turns it back", () => {
  const playback = new Playback();
  let before = playback.at(100, 100, 0.3);
  for (let now = 100.02; now < 110; now += 0.02) {
    const at = playback.at(now, now, 1.3);
    expect(at).toBeGreaterThan(before);
    before = at;
  }
  expect(before).toBeCloseTo(110 - 1.3, 1);
});

test("after a long absence playback begins anew", () => {
  const playback = new Playback();
  playback.at(100, 100, 1);
  expect(playback.at(500, 500, 1)).toBe(499);
});

test("better knowledge of the server's clock makes no leap", () => {
  const playback = new Playback();
  const before = playback.at(10, 100, 1);
  expect(playback.at(10.01, 100.06, 1) - before).toBeLessThan(0.012);
});
