import { expect, test } from "vitest";
import { wordsIn } from "./kept";
import type { Word } from "./words";

const said = { kind: "made", item: "pump-p3", vehicle: "", quantity: 2, key: "k1", sure: false, saidMs: 1 } as const;
const now: Word = { ...said, place: "S1", station: true };

test("what was kept is read as it was", () => {
  expect(wordsIn(JSON.stringify([now, { ...now, doubted: "12" }]))).toEqual([now, { ...now, doubted: "12" }]);
});

test("what an older page has kept was said at a machine", () => {
  expect(wordsIn(JSON.stringify([{ ...said, machine: "M8" }, now]))).toEqual([{ ...said, place: "M8", station: false }, now]);
});

test.each(["", "{", "{}", "null", "7"])("%j is no words", (written) => {
  expect(wordsIn(written)).toBeNull();
});
