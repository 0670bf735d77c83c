import { describe, expect, test } from "vitest";
import { KEPT_MS, type Place, seated, SETTLE_MS, settlesInMs } from "./places";

const NOBODY: ReadonlySet<string> = new Set();
const MANY = 14;
const names = (places: readonly Place[]) => places.map(({ atv }) => atv);
const states = (places: readonly Place[]) => places.map(({ state }) => state);

/** Who is near at which time, one after another, and the places that come of it. */
function after(...looks: [number, ...string[]][]): readonly Place[] {
  return looks.reduce<readonly Place[]>((places, [nowMs, ...near]) => seated(places, near, NOBODY, MANY, nowMs), []);
}

describe("a place in the Stop bar", () => {
  test("stays its vehicle's while others come and go", () => {
    const places = after([0, "ATV2", "ATV4", "ATV6"], [1000, "ATV4", "ATV6"], [2000, "ATV1", "ATV6", "ATV4"], [3000, "ATV6"]);
    expect(names(places)).toEqual(["ATV2", "ATV4", "ATV6", "ATV1"]);
    expect(states(places)).toEqual(["left", "left", "near", "left"]);
  });

  test("is there when its vehicle comes back, and may be touched at once", () => {
    const places = after([0, "ATV2", "ATV4"], [1000, "ATV4"], [2000, "ATV2", "ATV4"]);
    expect(names(places)).toEqual(["ATV2", "ATV4"]);
    expect(places.map((place) => settlesInMs(place, -Infinity, 2000))).toEqual([0, 0]);
  });

  test("shows nothing soon after its vehicle has left, and nobody moves by that", () => {
    const places = after([0, "ATV2", "ATV4"], [1000, "ATV4"], [1000 + KEPT_MS, "ATV4"]);
    expect(states(places)).toEqual(["free", "near"]);
    const back = seated(places, ["ATV2", "ATV4"], NOBODY, MANY, 9000);
    expect(names(back)).toEqual(["ATV2", "ATV4"]);
    expect(back.map((place) => settlesInMs(place, -Infinity, 9000))).toEqual([SETTLE_MS, 0]);
  });

  test("is given to a joining vehicle when no hand can be over it any more", () => {
    const places = after([0, "ATV2", "ATV4"], [1000, "ATV4"]);
    expect(names(seated(places, ["ATV4", "ATV9"], NOBODY, MANY, 999 + KEPT_MS))).toEqual(["ATV2", "ATV4", "ATV9"]);
    expect(names(seated(places, ["ATV4", "ATV9"], NOBODY, MANY, 1000 + KEPT_MS))).toEqual(["ATV9", "ATV4"]);
  });

  test("is given to a joining vehicle at once where else it would be out of sight, and counts no touch at first", () => {
    const before = seated([], ["ATV1", "ATV2", "ATV3"], NOBODY, 3, 0);
    const places = seated(seated(before, ["ATV1", "ATV3"], NOBODY, 3, 1000), ["ATV1", "ATV3", "ATV9"], NOBODY, 3, 1100);
    expect(names(places)).toEqual(["ATV1", "ATV9", "ATV3"]);
    expect(places.map((place) => settlesInMs(place, -Infinity, 1100))).toEqual([0, SETTLE_MS, 0]);
  });

  test("in sight goes to who is near and out of sight, as soon as its vehicle leaves", () => {
    const before = seated([], ["ATV1", "ATV2", "ATV3", "ATV4"], NOBODY, 3, 0);
    expect(names(seated(before, ["ATV1", "ATV3", "ATV4"], NOBODY, 3, 1000))).toEqual(["ATV1", "ATV4", "ATV3"]);
    // The tablet was turned, and shows more, or fewer.
    expect(names(seated(before, ["ATV2", "ATV3", "ATV4"], NOBODY, 4, 1000))).toEqual(["ATV1", "ATV2", "ATV3", "ATV4"]);
  });

  test("at the end is given up, since nobody moves by that", () => {
    const places = after([0, "ATV2", "ATV4", "ATV6"], [1000, "ATV4"]);
    expect(names(seated(places, ["ATV4"], NOBODY, MANY, 1000 + KEPT_MS))).toEqual(["ATV2", "ATV4"]);
  });

  test("is kept however long its vehicle is away, while a Stop to it is not confirmed", () => {
    const places = after([0, "ATV2", "ATV4"], [1000, "ATV2"]);
    const later = seated(places, ["ATV2", "ATV9"], new Set(["ATV4"]), 3, 10 * KEPT_MS);
    expect(names(later)).toEqual(["ATV2", "ATV4", "ATV9"]);
    expect(states(later)).toEqual(["near", "left", "near"]);
  });

  test("is left in sight for who is near even by one whose Stop is not confirmed", () => {
    const places = seated([], ["ATV2", "ATV4"], NOBODY, 2, 0);
    const later = seated(places, ["ATV2", "ATV9"], new Set(["ATV4"]), 2, 1000);
    expect(names(later)).toEqual(["ATV2", "ATV9", "ATV4"]);
    expect(states(later)).toEqual(["near", "near", "left"]);
  });

  test("is given to a vehicle that was told to stop and is not near, too", () => {
    const places = seated([], ["ATV2"], new Set(["ATV4"]), MANY, 0);
    expect(places).toMatchObject([{ atv: "ATV2", state: "near" }, { atv: "ATV4", state: "left" }]);
  });

  test("does not count touches while it is new, and the first ones do at once", () => {
    const places = after([0, "ATV2"], [1000, "ATV2", "ATV4"]);
    const left = (nowMs: number) => places.map((place) => settlesInMs(place, -Infinity, nowMs));
    expect(left(1000)).toEqual([0, SETTLE_MS]);
    expect(left(1400)).toEqual([0, SETTLE_MS - 400]);
    expect(left(1000 + SETTLE_MS)).toEqual([0, 0]);
  });

  test("does not count touches either just after the whole bar has moved", () => {
    const [place] = after([0, "ATV2"]);
    expect(place && settlesInMs(place, 2000, 2100)).toBe(SETTLE_MS - 100);
  });
});

/** Whole numbers below a bound, the same in every run. */
function drawn(seed: number): (below: number) => number {
  let state = seed;
  return (below) => {
    state = (state * 1_664_525 + 1_013_904_223) % 2 ** 32;
    return Math.floor((state / 2 ** 32) * below);
  };
}

/** Places in two rows: a tablet that lies, one that stands upright, a phone. */
test.each([14, 10, 6])("of fifty vehicles that pass for an hour none that is near is ever out of the %i places in sight", (inSight) => {
  const draw = drawn(inSight);
  const near = new Set<string>();
  const wrong: string[] = [];
  let places: readonly Place[] = [];
  for (let atMs = 0; atMs < 3_600_000; atMs += 500) {
    if (draw(2) === 0) {
      const atv = `ATV${String(draw(50))}`;
      if (!near.delete(atv) && near.size < inSight) near.add(atv);
    }
    const before = places;
    places = seated(before, [...near], NOBODY, inSight, atMs);
    const shown = new Set(names(places.slice(0, inSight)));
    for (const atv of near) if (!shown.has(atv)) wrong.push(`${atv} is out of sight at ${String(atMs)} ms`);
    if (new Set(names(places)).size < places.length) wrong.push(`somebody has two places at ${String(atMs)} ms`);
    for (const [i, place] of places.slice(0, inSight).entries()) {
      const owner = before[i];
      if (owner === undefined || owner.atv === place.atv) continue;
      if (owner.state === "near" && near.has(owner.atv)) wrong.push(`${owner.atv} was moved at ${String(atMs)} ms`);
      if (settlesInMs(place, -Infinity, atMs) < SETTLE_MS) wrong.push(`${place.atv} counts touches at ${String(atMs)} ms`);
    }
  }
  expect(wrong).toEqual([]);
});

test("nothing has changed is told by the very same places", () => {
  const places = after([0, "ATV2", "ATV4"], [1000, "ATV4"]);
  expect(seated(places, ["ATV4"], NOBODY, MANY, 2000)).toBe(places);
});
