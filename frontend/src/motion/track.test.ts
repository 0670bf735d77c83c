import { describe, expect, test } from "vitest";
import { roadsOf } from "./roads";
import { extend, poseAt, type Sighting, trackOf, turnTowards } from "./track";

const plain = { originals: [], map: "", max_vehicle: null };

/** A corner: a (0,0) - b (10,0) - c (10,10), and a dead end d beyond c. */
const roads = roadsOf({
  nodes: [
    { id: "a", x_m: 0, y_m: 0, ...plain },
    { id: "b", x_m: 10, y_m: 0, ...plain },
    { id: "c", x_m: 10, y_m: 10, ...plain },
    { id: "d", x_m: 10, y_m: 20, ...plain },
  ],
  lanes: [
    { start: "a", end: "b", speed_limit_mps: 1, both_ways: true, two_lanes: null, shape: [], types: [], original: null, original_back: null },
    { start: "b", end: "c", speed_limit_mps: 1, both_ways: true, two_lanes: null, shape: [], types: [], original: null, original_back: null },
    { start: "c", end: "d", speed_limit_mps: 1, both_ways: true, two_lanes: null, shape: [], types: [], original: null, original_back: null },
  ],
});

const seen = (t: number, x: number, y: number, node: string, way: string[]): Sighting => ({
  t, x, y, node, way, heading: 0,
});

describe("a track", () => {
  test("follows the lanes round a corner instead of cutting it", () => {
    const track = extend(trackOf(seen(0, 8, 0, "a", ["b", "c"])), seen(4, 10, 2, "b", ["c"]), roads, -1);
    expect(poseAt(track, 2)).toMatchObject({ x: 10, y: 0 });
    expect(poseAt(track, 1)).toMatchObject({ x: 9, y: 0, heading: 0 });
    expect(poseAt(track, 3).x).toBe(10);
    expect(poseAt(track, 3).heading).toBeCloseTo(Math.PI / 2);
  });

  test("stands still before its first and after its last knot", () => {
    const track = extend(trackOf(seen(0, 0, 0, "a", ["b"])), seen(1, 5, 0, "a", ["b"]), roads, -1);
    expect(poseAt(track, -5)).toMatchObject({ x: 0, y: 0 });
    expect(poseAt(track, 9)).toMatchObject({ x: 5, y: 0, moving: false });
  });

  test("starts from where it is shown when news comes after a long silence", () => {
    const parked = trackOf(seen(0, 0, 0, "a", []));
    const track = extend(parked, seen(5, 2, 0, "a", ["b"]), roads, 4);
    expect(poseAt(track, 4).x).toBe(0);
    expect(poseAt(track, 4.5).x).toBeCloseTo(1);
  });

  test("never leaps: news that comes too late is driven, not jumped over", () => {
    const track = extend(trackOf(seen(0, 0, 0, "a", ["b"])), seen(1, 1, 0, "a", ["b"]), roads, 3);
    expect(poseAt(track, 3).x).toBe(0);
    expect(poseAt(track, 3.1).x).toBeGreaterThan(0);
    expect(poseAt(track, 3.5).x).toBe(1);
  });

  test("never goes back, however uneven the news", () => {
    let track = trackOf(seen(0, 0, 0, "a", ["b"]));
    let shownX = 0;
    const news = [0.9, 2.4, 2.5, 4.1].map((t) => seen(t, t, 0, "a", ["b"]));
    for (let now = 0; now < 6; now += 0.05) {
      while (news[0] && news[0].t + 0.3 <= now) {
        const next = news.shift();
        if (next) track = extend(track, next, roads, now - 1);
      }
      const { x } = poseAt(track, now - 1);
      expect(x).toBeGreaterThanOrEqual(shownX);
      shownX = x;
    }
    expect(shownX).toBeCloseTo(4.1);
  });

  test("finds the way by the lanes where the plan does not tell it", () => {
    const track = extend(trackOf(seen(0, 0, 0, "a", [])), seen(2, 10, 10, "c", ["d"]), roads, -1);
    expect(poseAt(track, 1)).toMatchObject({ x: 10, y: 0 });
  });

  test("forgets what it has played", () => {
    let track = trackOf(seen(0, 0, 0, "a", ["b"]));
    for (let t = 1; t < 10; t += 1) track = extend(track, seen(t, t, 0, "a", ["b"]), roads, t - 1.2);
    expect(track.knots.length).toBeLessThan(5);
  });

  test("begins anew where a vehicle was set down far away", () => {
    const track = extend(trackOf(seen(0, 0, 0, "a", [])), seen(1, 500, 0, "z", []), roads, 0);
    expect(poseAt(track, 0)).toMatchObject({ x: 500, moving: false });
  });

  test("ignores news that is older than what it knows", () => {
    const track = extend(trackOf(seen(5, 3, 0, "a", ["b"])), seen(4, 1, 0, "a", ["b"]), roads, 0);
    expect(poseAt(track, 9).x).toBe(3);
  });
});

test("a heading turns the short way round", () => {
  const almost = turnTowards(3.1, -3.1, 0.5);
  expect(Math.abs(almost)).toBeCloseTo(Math.PI, 1);
  expect(turnTowards(0, Math.PI / 2, 1)).toBeCloseTo(Math.PI / 2);
});
