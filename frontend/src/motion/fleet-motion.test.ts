import { beforeEach, describe, expect, test } from "vitest";
import type { AtvView } from "../api/types";
import { FleetMotion } from "./fleet-motion";
import { roadsOf } from "./roads";

const plain = { originals: [], map: "", max_vehicle: null };
const lane = { speed_limit_mps: 1.5, both_ways: true, two_lanes: null, shape: [], types: [], original: null, original_back: null };
const roads = roadsOf({
  nodes: [{ id: "a", x_m: 0, y_m: 0, ...plain }, { id: "b", x_m: 50, y_m: 0, ...plain }],
  lanes: [{ start: "a", end: "b", ...lane }],
});
const at = (x_m: number, seen_at_s: number, beat_s = 1) =>
  ({ id: "ATV1", x_m, y_m: 0, seen_at_s, silence: { beat_s }, node: "a", way: ["b"], heading_rad: 0 }) as unknown as AtvView;

let fleet: FleetMotion;
const x = (): number => fleet.get("ATV1")?.x ?? NaN;
const play = (serverS: number, passedS = 0.02, smooth = true): boolean =>
  fleet.play({ serverS, passedS, speed: 1, smooth });

beforeEach(() => {
  fleet = new FleetMotion(roads);
});

/** Drives a vehicle at 1 m/s with a heartbeat every `beatS`; returns the longest step on the screen. */
function longestStepM(beatS: number): number {
  fleet.reset([at(0, 100, beatS)]);
  let longest = 0;
  let beats = 0;
  for (let now = 100; now < 130; now += 0.02) {
    if (now - 100 >= (beats + 1) * beatS) {
      beats += 1;
      fleet.observe([at(beats * beatS, 100 + beats * beatS, beatS)]);
    }
    const before = x();
    play(now);
    expect(x()).toBeGreaterThanOrEqual(before);
    longest = Math.max(longest, x() - before);
  }
  expect(x()).toBeGreaterThan(15);
  return longest;
}

describe("a fleet in motion", () => {
  test("glides between the heartbeats of a second at work", () => {
    expect(longestStepM(1)).toBeLessThan(0.04);
  });

  test("glides, too, where an idle vehicle speaks every five seconds only", () => {
    expect(longestStepM(5)).toBeLessThan(0.04);
  });

  test("needs no further picture once everybody stands", () => {
    fleet.reset([at(0, 100)]);
    fleet.observe([at(1, 101)]);
    expect(play(101.3)).toBe(true);
    for (let now = 101.3; now < 104; now += 0.02) play(now);
    expect(play(104)).toBe(false);
    expect(x()).toBe(1);
  });

  test("shows the last news at once to who asked for less motion", () => {
    fleet.reset([at(0, 100)]);
    fleet.observe([at(1, 101)]);
    expect(play(101.1, 0.1, false)).toBe(false);
    expect(x()).toBe(1);
    fleet.observe([at(2, 102)]);
    expect(play(102.1, 0.1, false)).toBe(false);
    expect(x()).toBe(2);
  });

  test("knows what is still ahead on the screen, not only in the plan", () => {
    fleet.reset([at(0, 100)]);
    fleet.observe([at(1, 101)]);
    play(101.3);
    expect(fleet.ahead("ATV1").map((point) => point.x)).toEqual([expect.closeTo(0.05, 1), 1, 50]);
    fleet.forget("ATV1");
    expect(fleet.ahead("ATV1")).toEqual([]);
  });
});
