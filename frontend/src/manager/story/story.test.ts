import { describe, expect, test } from "vitest";
import type { TaskView } from "../../api/types";
import { type Chosen, lastChosen, NOTHING } from "../../selection/selection";
import type { World } from "../../stream/world";
import { chosenFrom, saidOf } from "./address";
import { followed, isUnknown, storyOf } from "./story";

const task = (id: string, more: Partial<TaskView>) => ({
  id, kind: "transport", state: "contracted", coordinator: "M8", primary: "", secondary: "", goal: "", order: "", source: "",
  destination: "", opened_at_s: 1, bids: [], refusals: [], ...more,
}) as unknown as TaskView;

function worldOf(...tasks: TaskView[]): World {
  return {
    tasks: new Map(tasks.map((each) => [each.id, each])),
    atvs: new Map(["ATV1", "ATV2", "ATV3"].map((id) => [id, { id, task: null }])),
    machines: new Map(["M5", "M8"].map((id) => [id, { id, goals: id === "M5" ? [{ goal: "G2" }] : [] }])),
  } as unknown as World;
}

const OUT = task("M8-1", { primary: "ATV2", secondary: "ATV1", goal: "G1" });
const GOAL = task("G1", { kind: "production", coordinator: "strategist", primary: "M8", order: "O-7" });
const WORLD = worldOf(OUT, GOAL);
const story = (chosen: Chosen, world = WORLD, before = NOTHING) => storyOf(world, before, chosen);

describe("a selection is a whole story", () => {
  test.each([
    { kind: "task", id: "M8-1" }, { kind: "atv", id: "ATV2" }, { kind: "machine", id: "M8" }, { kind: "order", id: "O-7" },
  ] as const)("whatever of it is chosen: $kind", (chosen) => {
    expect(story(chosen)).toMatchObject({ atv: "ATV2", standby: "ATV1", place: { id: "M8" }, order: "O-7", latest: chosen.kind });
  });

  test("of a vehicle that only watches it is that of the transport, and the vehicle stays the chosen one", () => {
    expect(story({ kind: "atv", id: "ATV1" })).toMatchObject({ atv: "ATV1", standby: "ATV1", place: { id: "M8" }, order: "O-7" });
  });

  test("of a machine it is the order that it works at, where what is brought to it is for whatever order comes", () => {
    const material = task("M5-1", { coordinator: "M5", primary: "ATV3" });
    const goal = task("G2", { kind: "production", coordinator: "strategist", primary: "M5", order: "O-9" });
    expect(story({ kind: "machine", id: "M5" }, worldOf(material, goal))).toMatchObject({ atv: "ATV3", order: "O-9" });
    expect(story({ kind: "task", id: "M5-1" }, worldOf(material, goal))).toMatchObject({ place: { id: "M5" }, order: null });
  });

  test("of a goal it is its machine's", () => {
    expect(story({ kind: "task", id: "G1" })).toMatchObject({ place: { id: "M8" }, order: "O-7", standby: null, atv: null });
  });

  test("leaves the other card as it was where nothing belongs to what is chosen", () => {
    const before = story({ kind: "machine", id: "M8" });
    expect(story({ kind: "atv", id: "ATV3" }, WORLD, before)).toMatchObject({ atv: "ATV3", place: { id: "M8" }, standby: null, order: null });
  });

  test("is no story of what has ended, but where that itself is chosen", () => {
    const ended = worldOf({ ...OUT, state: "delivered" }, GOAL);
    expect(story({ kind: "atv", id: "ATV2" }, ended)).toMatchObject({ atv: "ATV2", place: null, order: null });
    expect(story({ kind: "task", id: "M8-1" }, ended)).toMatchObject({ atv: "ATV2", place: { id: "M8" } });
  });

  test("a lane is marked beside it", () => {
    const before = story({ kind: "task", id: "M8-1" });
    expect(story({ kind: "lane", id: "a b" }, WORLD, before)).toEqual({ ...before, lane: "a b" });
  });
});

describe("who follows it", () => {
  test("sees the one that has taken over", () => {
    const before = story({ kind: "task", id: "M8-1" });
    const after = worldOf({ ...OUT, primary: "ATV1", secondary: "" }, GOAL);
    expect(followed(after, before)).toMatchObject({ atv: "ATV1", standby: null, order: "O-7" });
  });

  test("has the same object while nothing changes", () => {
    const before = story({ kind: "task", id: "M8-1" });
    expect(followed(WORLD, before)).toBe(before);
    expect(followed(WORLD, NOTHING)).toBe(NOTHING);
  });
});

test("what is chosen is said in an address, and read from it", () => {
  for (const chosen of [{ kind: "task", id: "M8.1-2:x" }, { kind: "atv", id: "ATV2" }] as const) {
    expect(chosenFrom(saidOf(chosen))).toEqual(chosen);
    expect(lastChosen(story(chosen))).toEqual(chosen);
  }
  for (const nonsense of [undefined, "", "atv", "atv:", "colour:red", ":x"]) expect(chosenFrom(nonsense)).toBeNull();
});

describe("a link of another plant", () => {
  test.each([
    [{ kind: "atv", id: "ATV1" }, false], [{ kind: "atv", id: "NOPE" }, true], [{ kind: "machine", id: "ATV1" }, true],
    [{ kind: "task", id: "ended" }, false], [{ kind: "order", id: "delivered" }, false],
  ] as const)("%o names what is not there: %s", (chosen, unknown) => {
    expect(isUnknown(WORLD, chosen)).toBe(unknown);
  });

  test("says nothing before the plant is there", () => {
    expect(isUnknown(null, { kind: "atv", id: "ATV1" })).toBe(false);
  });
});
