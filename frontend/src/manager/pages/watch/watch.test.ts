import { describe, expect, test } from "vitest";
import type { AtvView, TaskView } from "../../../api/types";
import type { World } from "../../../stream/world";
import { statusCounts } from "../../cards/factory/status";
import { isExposed, isFound, passes, watches } from "./watch";

const NOW_S = 100;
const task = (id: string, primary: string, more: Partial<TaskView> = {}) =>
  ({ id, kind: "transport", state: "contracted", coordinator: "M8", primary, secondary: "", goods_aboard: false, phase: "approaching", ...more }) as TaskView;
const atv = (id: string, ageS: number) => ({ id, task: {}, status: "working", seen_at_s: NOW_S - ageS, shut_out: null, silence: { beat_s: 1, overdue_after_s: 1.5, lost_after_s: 3.5 } }) as unknown as AtvView;

function world(tasks: TaskView[], atvs: AtvView[]): World {
  return {
    tasks: new Map(tasks.map((each) => [each.id, each])),
    atvs: new Map(atvs.map((each) => [each.id, each])),
    factory: { speed: 1 },
  } as unknown as World;
}

describe("who watches whom", () => {
  const shown = watches(
    world(
      [
        task("M8-1", "ATV10", { secondary: "ATV1" }),
        task("M8-2", "ATV2"),
        task("M8-3", "ATV3", { secondary: "ATV1" }),
        task("M8-4", "ATV4"),
        task("M8-5", "", { state: "bidding" }),
        task("G1", "M2", { kind: "production" }),
        task("M8-6", "ATV6", { secondary: "ATV1" }),
      ],
      [atv("ATV1", 0.2), atv("ATV10", 0.2), atv("ATV2", 0.2), atv("ATV3", 2), atv("ATV4", 9), atv("ATV6", 0.2)],
    ),
    NOW_S,
  );

  test("begins with who is silent, then who is overdue, then who has no watch", () => {
    expect(shown.map(({ state, task: { primary } }) => [primary, state])).toEqual([
      ["ATV4", "silent"], ["ATV3", "overdue"], ["ATV2", "unwatched"], ["ATV6", "watched"], ["ATV10", "watched"],
    ]);
  });

  test("warns only where nobody would take over from who may have failed", () => {
    expect(shown.filter(isExposed).map((each) => each.task.primary)).toEqual(["ATV4"]);
    const aboard = watches(world([task("M8-7", "ATV4", { goods_aboard: true })], [atv("ATV4", 9)]), NOW_S);
    expect(aboard.filter(isExposed)).toEqual([]);
  });

  test("can be filtered by what is wrong, and by name", () => {
    const named = (filter: Parameters<typeof passes>[1]) =>
      shown.filter((each) => passes(each, filter)).map((each) => each.task.primary);
    expect(named("watched")).toEqual(["ATV3", "ATV6", "ATV10"]);
    expect(named("unwatched")).toEqual(["ATV4", "ATV2"]);
    expect(named("overdue")).toEqual(["ATV4", "ATV3"]);
    expect(shown.filter((each) => isFound(each, " atv1 ")).map((each) => each.task.id)).toEqual(["M8-3", "M8-6", "M8-1"]);
  });

  test("tells goods on board from a watch that is only missing", () => {
    const goods = task("M8-7", "ATV2", { goods_aboard: true });
    const aboard = watches(world([goods, task("M8-8", "ATV3")], []), NOW_S);
    expect(aboard.map((each) => each.aboard)).toEqual([true, false]);
    expect(aboard[0]?.carrier).toBeNull();
  });
});

test("who is silent is counted as silent, whatever it said last", () => {
  expect(statusCounts([atv("ATV1", 0), atv("ATV2", 1), atv("ATV3", 60)], NOW_S, 1)).toEqual({ working: 2, lost: 1 });
});
