import { describe, expect, test } from "vitest";
import { KEPT_MS, type Place, seated, SETTLE_MS, settlesInMs } from "./places";

const NOBODY: ReadonlySet<string> = new Set();
const names = (places: readonly Place[]) => places.map(({ atv }) => atv);

/** Who is near at which time, one after another, and the places that come of it. */
function after(...looks: [number, ...string[]][]): readonly Place[] {
  return looks.reduce<readonly Place[]>((places, [nowMs, ...near]) => seated(places, near, NOBODY, nowMs), []);
}

describe("a place in the Stop bar", () => {
  test("stays its vehicle's while others come and go", () => {
    const places = after([0, "ATV2", "ATV4", "ATV6"], [1000, "ATV4", "ATV6"], [2000, "ATV1", "ATV6", "ATV4"], [3000, "ATV6"]);
    expect(names(places)).toEqual(["ATV2", "ATV4", "ATV6", "ATV1"]);
    expect(places.map(({ present }) => present)).toEqual([false, false, true, false]);
  });

  test("is there when its vehicle comes back, and may be touched at once", () => {
    const places = after([0, "ATV2", "ATV4"], [1000, "ATV4"], [KEPT_MS, "ATV2", "ATV4"]);
    expect(names(places)).toEqual(["ATV2", "ATV4"]);
    expect(places.map((place) => settlesInMs(place, -Infinity, KEPT_MS))).toEqual([0, 0]);
  });

  test("is given to a joining vehicle only after its vehicle was away for long", () => {
    const places = after([0, "ATV2", "ATV4"], [1000, "ATV4"]);
    expect(names(seated(places, ["ATV4", "ATV9"], NOBODY, 999 + KEPT_MS))).toEqual(["ATV2", "ATV4", "ATV9"]);
    expect(names(seated(places, ["ATV4", "ATV9"], NOBODY, 1000 + KEPT_MS))).toEqual(["ATV9", "ATV4"]);
  });

  test("at the end is given up, since nobody moves by that; one in the middle stays", () => {
    const places = after([0, "ATV2", "ATV4", "ATV6"], [1000, "ATV4"]);
    expect(names(seated(places, ["ATV4"], NOBODY, 1000 + KEPT_MS))).toEqual(["ATV2", "ATV4"]);
  });

  test("is kept however long its vehicle is away, while a Stop to it is not confirmed", () => {
    const places = after([0, "ATV2", "ATV4"], [1000, "ATV2"]);
    expect(names(seated(places, ["ATV2", "ATV9"], new Set(["ATV4"]), 10 * KEPT_MS))).toEqual(["ATV2", "ATV4", "ATV9"]);
  });

  test("is given to a vehicle that was told to stop and is not near, too", () => {
    expect(seated([], ["ATV2"], new Set(["ATV4"]), 0)).toMatchObject([{ atv: "ATV2", present: true }, { atv: "ATV4", present: false }]);
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

test("of a hundred vehicles that pass by none ever takes a place within the time that it is kept", () => {
  let places: readonly Place[] = [];
  const owners: { atMs: number; atv: string }[][] = [];
  for (let atMs = 0; atMs < 20 * KEPT_MS; atMs += 700) {
    const first = Math.floor(atMs / 5_000);
    const near = Array.from({ length: 8 }, (_, i) => `ATV${(first + i * 7) % 100}`);
    places = seated(places, near, NOBODY, atMs);
    for (const [i, { atv, present }] of places.entries()) {
      if (!present) continue;
      const last = (owners[i] ??= []).at(-1);
      if (last?.atv === atv) last.atMs = atMs;
      else {
        if (last) expect(atMs - last.atMs).toBeGreaterThanOrEqual(KEPT_MS);
        owners[i].push({ atMs, atv });
      }
    }
    expect(new Set(names(places)).size).toBe(places.length);
    expect(near.every((atv) => names(places).includes(atv))).toBe(true);
  }
  expect(places.length).toBeLessThan(8 + 2 * (KEPT_MS / 5_000) * 8);
});

test("nothing has changed is told by the very same places", () => {
  const places = after([0, "ATV2", "ATV4"], [1000, "ATV4"]);
  expect(seated(places, ["ATV4"], NOBODY, 5000)).toBe(places);
});
