import { describe, expect, test } from "vitest";
import type { AtvView, Delta, Snapshot } from "../../../api/types";
import { nothing } from "../../../stream/nothing";
import { everyS, markBeside, type Mark, play, rangeAround, reelOf } from "./film";
import { barsOf, doneNow, type Spell } from "./strips";

const snapshot = {
  ...nothing, type: "snapshot", number: 0, at_s: 100, plant: "p", factory: { speed: 1 },
  atvs: [{ id: "ATV1", node: "a" } as AtvView], fault_injection: false, audience: null,
} as unknown as Snapshot;

const frame = (number: number, atS: number, node: string): Delta =>
  ({ ...snapshot, type: "delta", number, at_s: atS, factory: null, atvs: [{ id: "ATV1", node }], gone: [] }) as unknown as Delta;

const film = { snapshot, frames: [frame(1, 101, "b"), frame(2, 102, "c")], until_at_s: 110 };

describe("a film", () => {
  test("shows at a moment what the frames up to it have told", () => {
    const at = play(reelOf(film), 101.5);
    expect(at.reel.world.atvs.get("ATV1")?.node).toBe("b");
    expect(at.shown).toHaveLength(1);
    expect(play(at.reel, 105).reel.world.atvs.get("ATV1")?.node).toBe("c");
  });

  test("leaves no frame out at the pace of the stream, and some where time runs", () => {
    expect([0.25, 1, 4].map(everyS)).toEqual([0, 0, 0]);
    expect(everyS(60)).toBeCloseTo(7.5);
  });
});

test("the next mark is not the one that is shown", () => {
  const marks = [10, 20, 30].map((atS) => ({ at_s: atS, kind: "alert", about: "" }) as Mark);
  expect(markBeside(marks, 20, 1)?.at_s).toBe(30);
  expect(markBeside(marks, 20.2, -1)?.at_s).toBe(10);
  expect(markBeside(marks, 10, -1)).toBeNull();
});

test("a time ends now where it holds the moment, and has the moment in its middle before", () => {
  expect(rangeAround(900, 200, 1000)).toEqual({ fromS: 800, toS: 1000 });
  expect(rangeAround(500, 200, 1000)).toEqual({ fromS: 400, toS: 600 });
});

describe("a strip", () => {
  const spell = (doing: Spell["doing"], fromS: number, toS: number) =>
    ({ agent: "ATV1", doing, from_at_s: fromS, until_at_s: toS, task: "", item: "", source: "", destination: "", other: "" });

  test("has bars within its time, in percent of it", () => {
    expect(barsOf([spell("idle", -50, 50), spell("carries", 50, 100)], { fromS: 0, toS: 100 })).toMatchObject([
      { left: 0, width: 50 }, { left: 50, width: 50 },
    ]);
  });

  test("tells what is done at a moment", () => {
    expect(doneNow([spell("idle", 0, 50), spell("carries", 50, 100)], 70)?.doing).toBe("carries");
    expect(doneNow([spell("idle", 0, 50)], 70)).toBeUndefined();
  });
});
