import { describe, expect, test } from "vitest";
import { linksOf, spellBeside, SPANS_S, zoomedSpan } from "./links";
import type { Spell } from "./strips";

const EVERYBODY = new Set(["ATV1", "ATV3", "ATV7", "M8"]);

function spell(agent: string, doing: Spell["doing"], fromS: number, untilS: number, more: Partial<Spell> = {}): Spell {
  return { agent, doing, from_at_s: fromS, until_at_s: untilS, task: "", item: "", source: "", destination: "", other: "", ...more };
}

const told = (links: ReturnType<typeof linksOf>): string[] => links.map(({ agent, atS, kind }) => `${kind} ${agent} ${atS}`);

describe("a spell leads", () => {
  test("from who waits to whom it waits for, and back", () => {
    const waits = spell("ATV1", "waits", 10, 30, { other: "ATV3" });
    const docked = spell("ATV3", "carries", 5, 40, { destination: "M8" });
    expect(told(linksOf(waits, [waits, docked], EVERYBODY))).toEqual(["waitsFor ATV3 10"]);
    expect(told(linksOf(docked, [waits, docked], EVERYBODY))).toEqual(["bringsTo M8 40", "waitedFor ATV1 10"]);
  });

  test("from a takeover to both sides of it", () => {
    const lost = spell("ATV3", "carries", 0, 20, { task: "M8-1" });
    const silent = spell("ATV3", "silent", 20, 90);
    const took = spell("ATV1", "fetches", 33, 50, { task: "M8-1" });
    const all = [lost, silent, took, spell("ATV7", "carries", 30, 60, { task: "M8-2" })];
    expect(told(linksOf(lost, all, EVERYBODY))).toEqual(["takenBy ATV1 33"]);
    expect(told(linksOf(took, all, EVERYBODY))).toEqual(["takenFrom ATV3 0"]);
  });

  test("from a machine to who brings and fetches, each once", () => {
    const makes = spell("M8", "makes", 0, 100);
    const all = [
      makes, spell("ATV1", "carries", 10, 30, { destination: "M8" }), spell("ATV1", "carries", 60, 80, { destination: "M8" }),
      spell("ATV7", "fetches", 20, 40, { source: "M8" }), spell("ATV3", "carries", 110, 130, { destination: "M8" }),
    ];
    expect(told(linksOf(makes, all, EVERYBODY))).toEqual(["brings ATV1 10", "fetches ATV7 20"]);
  });

  test("to nobody who has no strip", () => {
    expect(linksOf(spell("ATV1", "fetches", 0, 9, { source: "S5", destination: "M9" }), [], EVERYBODY)).toEqual([]);
    expect(linksOf(spell("ATV1", "waits", 0, 9, { other: "c2" }), [], EVERYBODY)).toEqual([]);
  });
});

test("what was before and after a moment's own", () => {
  const own = [spell("ATV1", "idle", 0, 10), spell("ATV1", "fetches", 10, 20), spell("ATV1", "carries", 20, 30)];
  expect(spellBeside(own, 15, -1)?.doing).toBe("idle");
  expect(spellBeside(own, 15, 1)?.doing).toBe("carries");
  expect(spellBeside(own, 5, -1)).toBeUndefined();
  expect(spellBeside(own, 25, 1)).toBeUndefined();
  expect(spellBeside(own, 40, -1)?.doing).toBe("carries");
});

test("a zoom goes step by step and ends at both ends", () => {
  expect(zoomedSpan(720, "in")).toBe(360);
  expect(zoomedSpan(720, "out")).toBe(1800);
  expect(zoomedSpan(SPANS_S[0], "in")).toBe(SPANS_S[0]);
  expect(zoomedSpan(28_800, "out")).toBe(28_800);
});
