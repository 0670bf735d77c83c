import { describe, expect, test } from "vitest";
import type { Command } from "../commands/life";
import { isWorrying, openOf } from "./unconfirmed";

const stop = (more: Partial<Command> = {}): Command => ({
  id: "1", atv: "ATV3", kind: "stop", speedFrac: null, by: "North", stage: "not_confirmed", accepted: true, reason: "", detail: "", atS: 100, ...more,
});
const open = (commands: Command[], atvs: Record<string, { status: "stopped" | "working"; seen_at_s: number }> = {}, seen: string[] = []) =>
  [...openOf(commands, new Map(Object.entries(atvs)), new Set(seen)).values()].map(({ id }) => id);

describe("a Stop that is not confirmed", () => {
  test.each(["sent", "accepted", "not_confirmed", "not_sent", "refused"] as const)("stays open: %s", (stage) => {
    expect(open([stop({ stage })])).toEqual(["1"]);
  });

  test("stays open though its vehicle is not seen any more, or is seen to drive", () => {
    expect(open([stop()], {})).toEqual(["1"]);
    expect(open([stop()], { ATV3: { status: "working", seen_at_s: 200 } })).toEqual(["1"]);
  });

  test("is over by the vehicle's word, late or in a heartbeat; not by what it said before", () => {
    expect(open([stop({ stage: "confirmed" })])).toEqual([]);
    expect(open([stop()], { ATV3: { status: "stopped", seen_at_s: 101 } })).toEqual([]);
    expect(open([stop()], { ATV3: { status: "stopped", seen_at_s: 99 } })).toEqual(["1"]);
  });

  test("is over when a later one is confirmed, or the vehicle was let go on; another command changes nothing", () => {
    expect(open([stop(), stop({ id: "2", atS: 110, stage: "confirmed" })])).toEqual([]);
    expect(open([stop(), stop({ id: "2", atS: 110, kind: "resume", stage: "confirmed" })])).toEqual([]);
    expect(open([stop(), stop({ id: "2", atS: 110, kind: "resume", stage: "refused" })])).toEqual(["1"]);
    expect(open([stop(), stop({ id: "2", atS: 110, kind: "set_speed", stage: "confirmed" })])).toEqual(["1"]);
  });

  test("is over when a person has seen to it, until the next one", () => {
    expect(open([stop()], {}, ["1"])).toEqual([]);
    expect(open([stop(), stop({ id: "2", atS: 120 })], {}, ["1"])).toEqual(["2"]);
  });

  test("keeps its place in the order: new ones come last", () => {
    expect(open([stop({ atS: 105 }), stop({ id: "2", atv: "ATV1", atS: 103 })])).toEqual(["2", "1"]);
  });
});

test("one under way is worth a word only when the answer should have come", () => {
  expect(isWorrying(stop({ stage: "sent" }), 101)).toBe(false);
  expect(isWorrying(stop({ stage: "accepted" }), 103)).toBe(true);
  expect(isWorrying(stop({ stage: "not_sent" }), 100)).toBe(true);
});
