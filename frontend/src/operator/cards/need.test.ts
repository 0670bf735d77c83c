import { describe, expect, test } from "vitest";
import type { AtvView, BriefView, HelpView } from "../../api/types";
import { groupsOf, movedCards, needOf, patienceS, shownGroups } from "./need";

const NOW = { nowS: 1000, speed: 1 };
const atv = (id: string, more: Partial<AtvView> = {}): AtvView =>
  ({ id, status: "idle", problem: "", help: null, out_of_service: null, task: null, seen_at_s: 999, shut_out: null, silence: { beat_s: 5, overdue_after_s: 5.5, lost_after_s: 15.5 }, ...more }) as AtvView;
const waiting = (until_at_s: number, promised_by = ""): Partial<AtvView> => ({
  problem: "the load has shifted", status: "error", help: { until_at_s, promised_by, promise_max_s: 900 } satisfies HelpView,
});
const task = { task: "M8-1" } as BriefView;

describe("what a vehicle needs", () => {
  test.each<[string, Partial<AtvView>, string]>([
    ["asks for help", waiting(1200), "help"],
    ["has been promised some", waiting(1200, "North"), "coming"],
    ["is stopped by a person while its task waits", { status: "stopped", help: { until_at_s: 1100, promised_by: "", promise_max_s: 900 } }, "stopped"],
    ["is stopped with a problem", { ...waiting(1200), status: "stopped" }, "stopped"],
    ["has a problem and no task", { status: "error", problem: "battery empty" }, "problem"],
    ["is held by a person", { status: "stopped" }, "stopped"],
    ["carries something", { status: "working", task }, "working"],
    ["has nothing to do", {}, "resting"],
    ["is not heard, whatever it was doing", { ...waiting(1200), seen_at_s: 900 }, "lost"],
  ])("one that %s", (_, more, need) => {
    expect(needOf(atv("ATV1", more), NOW)).toBe(need);
  });
});

describe("the order of cards", () => {
  test("is that of need; among those who wait, of how long they will", () => {
    const all = [
      atv("ATV10"), atv("ATV2"), atv("ATV3", { status: "working", task }), atv("ATV4", { status: "stopped" }),
      atv("ATV5", waiting(1100, "North")), atv("ATV6", waiting(1300)), atv("ATV7", waiting(1200)),
      atv("ATV8", { seen_at_s: 0 }), atv("ATV9", { problem: "battery empty" }),
    ];
    expect(groupsOf(all, NOW)).toEqual({
      needing: ["ATV7", "ATV6", "ATV5", "ATV9", "ATV8", "ATV4"],
      well: ["ATV2", "ATV3", "ATV10"],
    });
  });

  test("lets whoever needs somebody come first while nobody touches it", () => {
    const wanted = { needing: ["ATV2"], well: ["ATV1"] };
    expect(shownGroups({ needing: [], well: ["ATV1", "ATV2"] }, wanted, false)).toEqual(wanted);
  });

  test("keeps every place: new ones join below, and who has left keeps its own while a hand may be over it", () => {
    const before = { needing: [], well: ["ATV5", "ATV7"] };
    const wanted = { needing: [], well: ["ATV1", "ATV7"] };
    expect(shownGroups(before, wanted, false, new Set(["ATV5"])).well).toEqual(["ATV5", "ATV7", "ATV1"]);
    expect(shownGroups(before, wanted, false).well).toEqual(["ATV7", "ATV1"]);
    expect(shownGroups(before, wanted, true, new Set(["ATV5"])).well).toEqual(["ATV5", "ATV7", "ATV1"]);
  });

  test("tells which cards have come to another place: those behind the first change, and none that joins at the end", () => {
    const before = { needing: ["ATV9"], well: ["ATV1", "ATV2", "ATV3"] };
    expect(movedCards(before, before)).toEqual([]);
    expect(movedCards(before, { ...before, well: [...before.well, "ATV4"] })).toEqual([]);
    expect(movedCards(before, { ...before, well: ["ATV1", "ATV3"] })).toEqual(["ATV3"]);
    expect(movedCards(before, { needing: ["ATV9", "ATV1"], well: ["ATV2", "ATV3"] })).toEqual(["ATV1", "ATV2", "ATV3"]);
  });

  test("is kept among those who need somebody: new ones join below", () => {
    const before = { needing: ["ATV5", "ATV9"], well: ["ATV1"] };
    const wanted = { needing: ["ATV1", "ATV9", "ATV5"], well: [] };
    expect(shownGroups(before, wanted, false).needing).toEqual(["ATV5", "ATV9", "ATV1"]);
  });

  test("is by name among those who are well, whatever they do", () => {
    const does = (working: string) => groupsOf([atv("ATV1"), atv("ATV2")].map((each) => (each.id === working ? { ...each, task } : each)), NOW).well;
    expect(does("ATV1")).toEqual(does("ATV2"));
  });

  test("stays under a finger: who has gone is gone, who comes is last", () => {
    const before = { needing: ["ATV5"], well: ["ATV1", "ATV2", "ATV3"] };
    const wanted = { needing: ["ATV4", "ATV3"], well: ["ATV5", "ATV1"] };
    expect(shownGroups(before, wanted, true)).toEqual({ needing: ["ATV5"], well: ["ATV1", "ATV3", "ATV4"] });
  });

  test("is the very same one where nothing has changed", () => {
    const before = { needing: [], well: ["ATV1", "ATV2"] };
    expect(shownGroups(before, { needing: [], well: ["ATV1", "ATV2"] }, false)).toBe(before);
    expect(shownGroups(before, { needing: ["ATV2"], well: ["ATV1"] }, true)).toBe(before);
  });
});

test("patience is counted on the factory's clock, and goes on after its end", () => {
  expect(patienceS({ help: { until_at_s: 1010, promised_by: "", promise_max_s: 900 } }, { nowS: 1000, speed: 20 })).toBe(200);
  expect(patienceS({ help: { until_at_s: 990, promised_by: "", promise_max_s: 900 } }, NOW)).toBe(-10);
  expect(patienceS({ help: null }, NOW)).toBeNull();
});
