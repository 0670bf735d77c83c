import { describe, expect, test } from "vitest";
import { barsOfExpected, barsOfGoal, barsOfLeg, dueOnAxis, type Goal, groupsOf, type Leg, legendOf, percentOf, signsOf, spanOf, type Story, ticksOf, type Transport } from "./lanes";
import { goalNote } from "./Lanes";
import { momentText, transportText } from "./moments";

const goal = (more: Partial<Goal>): Goal => ({
  goal: "O-1.1", product: "g2", quantity: 10, machine: "M9", made: 0, delivered: 0, taken_at_s: 100, begun_at_s: null, last_at_s: null,
  promised_at_s: null, first_promised_at_s: null, came_before: 0, ended: "", ended_at_s: null, successor: "", doing: "making", doing_since_at_s: 100, behind: 0, ...more,
});
const leg = (more: Partial<Leg>): Leg => ({ carrier: "ATV1", since_at_s: 200, aboard_at_s: null, until_at_s: null, replaced: "", ...more });
const transport = (legs: Leg[], more: Partial<Transport> = {}): Transport => ({
  task: "M9.1-1", goal: "O-1.1", item: "g2", quantity: 5, source: "M9", destination: "OUT", opened_at_s: 190, closed_at_s: null, outcome: "", legs, thing: "", ...more,
});
const story = (more: Partial<Story>): Story => ({ goals: [], transports: [], moments: [], is_whole: true, expected: null, late: "", links: [], estimates: [], ...more });

describe("a goal's bars", () => {
  test("end where its last piece was made, or go on to what is promised", () => {
    expect(barsOfGoal(goal({ made: 10, last_at_s: 300, promised_at_s: 400 }), 900)).toEqual([{ kind: "made", fromS: 100, toS: 300 }]);
    expect(barsOfGoal(goal({ made: 4, last_at_s: 150, promised_at_s: 400 }), 200)).toEqual([
      { kind: "made", fromS: 100, toS: 200 },
      { kind: "open", fromS: 200, toS: 400 },
    ]);
    // Later than promised there is nothing left to promise.
    expect(barsOfGoal(goal({ promised_at_s: 400 }), 500)).toEqual([{ kind: "made", fromS: 100, toS: 500 }]);
    expect(barsOfGoal(goal({ ended: "lost", ended_at_s: 250, made: 1, last_at_s: 250 }), 900)).toEqual([{ kind: "made", fromS: 100, toS: 250 }]);
    expect(barsOfGoal(goal({ taken_at_s: null, doing: "" }), 900)).toEqual([]);
  });

  test("wait while the machine makes something else, and as long as it has no material", () => {
    for (const doing of ["busy", "starved", "broken", "silent"] as const) {
      expect(barsOfGoal(goal({ doing, doing_since_at_s: null, promised_at_s: 150 }), 200)).toEqual([{ kind: "waits", fromS: 100, toS: 200 }]);
    }
    expect(barsOfGoal(goal({ doing_since_at_s: 180 }), 200)).toEqual([
      { kind: "waits", fromS: 100, toS: 180 },
      { kind: "made", fromS: 180, toS: 200 },
    ]);
    // One piece each 10 s: it began 10 s before the first.
    const paced = { made: 3, begun_at_s: 150, last_at_s: 170 };
    expect(barsOfGoal(goal({ ...paced, doing: "busy", doing_since_at_s: null }), 200)).toEqual([
      { kind: "waits", fromS: 100, toS: 140 },
      { kind: "made", fromS: 140, toS: 170 },
      { kind: "waits", fromS: 170, toS: 200 },
    ]);
    expect(barsOfGoal(goal({ ...paced, doing_since_at_s: 140 }), 175)).toEqual([
      { kind: "waits", fromS: 100, toS: 140 },
      { kind: "made", fromS: 140, toS: 175 },
    ]);
    expect(barsOfGoal(goal({ ...paced, doing_since_at_s: 190 }), 200)).toEqual([
      { kind: "waits", fromS: 100, toS: 140 },
      { kind: "made", fromS: 140, toS: 170 },
      { kind: "waits", fromS: 170, toS: 190 },
      { kind: "made", fromS: 190, toS: 200 },
    ]);
    expect(barsOfGoal(goal({ ...paced, quantity: 3, doing: "", doing_since_at_s: null }), 900)).toEqual([
      { kind: "waits", fromS: 100, toS: 140 },
      { kind: "made", fromS: 140, toS: 170 },
    ]);
  });

  test("say in a note why the machine does not work at it, and that a promise is overdue", () => {
    expect(goalNote(goal({ promised_at_s: 400 }), 200)).toMatch(/^0 of 10 made · promised by \d\d:\d\d$/);
    expect(goalNote(goal({ doing: "busy", behind: 1, promised_at_s: 150 }), 200)).toMatch(/^0 of 10 made · waits behind 1 goal · promised by \d\d:\d\d, overdue$/);
    expect(goalNote(goal({ doing: "busy", behind: 2 }), 200)).toBe("0 of 10 made · waits behind 2 goals");
    expect(goalNote(goal({ doing: "starved", made: 4 }), 200)).toBe("4 of 10 made · waits for material");
    expect(goalNote(goal({ doing: "", made: 4, promised_at_s: 150 }), Infinity)).toBe("4 of 10 made");
    expect(goalNote(goal({ doing: "", made: 10, promised_at_s: 150 }), 200)).toBe("10 of 10 made");
  });
});

describe("a promise that its machine has moved", () => {
  const moved = { promised_at_s: 4000, first_promised_at_s: 400, doing: "busy", behind: 1 } as const;

  test("is told with the first one, and with what came before", () => {
    expect(goalNote(goal({ ...moved, came_before: 3 }), 500)).toMatch(
      /^0 of 10 made · waits behind 1 goal · promised by \d\d:\d\d, moved from \d\d:\d\d: 3 more urgent goals came before it$/,
    );
    expect(goalNote(goal({ ...moved, came_before: 1 }), 500)).toMatch(/: 1 more urgent goal came before it$/);
    expect(goalNote(goal({ ...moved, came_before: 1 }), 4500)).toMatch(/promised by \d\d:\d\d, overdue, moved from \d\d:\d\d: 1 more urgent goal came before it$/);
  });

  test("has no such reason where it was moved for another one", () => {
    expect(goalNote(goal({ ...moved, came_before: 0 }), 500)).toMatch(/, moved from \d\d:\d\d$/);
    expect(goalNote(goal({ ...moved, promised_at_s: 350, came_before: 2 }), 300)).toMatch(/, moved from \d\d:\d\d$/);
  });

  test("is what the bar goes on to", () => {
    expect(barsOfGoal(goal({ ...moved, doing_since_at_s: null }), 500).at(-1)).toEqual({ kind: "open", fromS: 500, toS: 4000 });
  });
});

describe("a carrier's bars", () => {
  test("tell fetching from carrying, and who was replaced", () => {
    expect(barsOfLeg(leg({}), 230)).toEqual([{ kind: "fetch", fromS: 200, toS: 230 }]);
    expect(barsOfLeg(leg({ aboard_at_s: 240, until_at_s: 300 }), 900)).toEqual([
      { kind: "fetch", fromS: 200, toS: 240 },
      { kind: "carry", fromS: 240, toS: 300 },
    ]);
    expect(barsOfLeg(leg({ aboard_at_s: 240, until_at_s: 260, replaced: "silent" }), 900)).toEqual([{ kind: "lost", fromS: 200, toS: 260 }]);
    // A clock that is behind makes no bar of a negative length.
    expect(barsOfLeg(leg({}), 150)).toEqual([{ kind: "fetch", fromS: 200, toS: 200 }]);
  });
});

describe("what a factory left open that was started anew", () => {
  const ended = { ended: "started_anew", ended_at_s: 250, made: 4, begun_at_s: 150, last_at_s: 180, doing: "", doing_since_at_s: null } as const;

  test("ends there, and promises nothing", () => {
    expect(barsOfGoal(goal(ended), 900).at(-1)).toEqual({ kind: "waits", fromS: 180, toS: 250 });
    expect(goalNote(goal(ended), 900)).toBe("4 of 10 made");
  });

  test("is told with its reason, and by nobody as handed over", () => {
    const told = transportText(transport([leg({ until_at_s: 250 })], { outcome: "started_anew", closed_at_s: 250 }), 900);
    expect(told).toMatch(/^ATV1 worked on it until .+ It ended when the factory was started anew\.$/);
  });
});

test("transports stand under the goal whose pieces they carry", () => {
  const groups = groupsOf(story({ goals: [goal({}), goal({ goal: "O-1.2" })], transports: [transport([leg({})])] }), 300);
  expect(groups.map((group) => group.transports.length)).toEqual([1, 0]);
});

describe("the axis", () => {
  test("reaches from the order's beginning over all that is told, due and expected", () => {
    const span = spanOf(groupsOf(story({ goals: [goal({})] }), 500), [500, null, 700], 90);
    expect(span.fromS).toBe(90);
    expect(span.toS).toBeGreaterThan(700);
    expect(percentOf(span, 90)).toBe(0);
    expect(percentOf(span, 1e6)).toBe(100);
    expect(percentOf(span, 0)).toBe(0);
  });

  test("ends with the order, and not with what was promised or due after that", () => {
    const ended = story({ goals: [goal({ made: 4, promised_at_s: 900 })], transports: [transport([leg({ aboard_at_s: 240, until_at_s: 300 })])] });
    const groups = groupsOf(ended, 500, true);
    expect(groups[0]?.bars.map(({ kind }) => kind)).not.toContain("open");
    const span = spanOf(groups, [500, dueOnAxis(4000, 500)], 100, true);
    expect(span.toS).toBe(500 + 400 * 0.04);
    // It was short, and the axis is short, too.
    const short = spanOf(groupsOf(story({}), 112, true), [112], 90, true);
    expect(short).toEqual({ fromS: 90, toS: 112 + 22 * 0.04 });
    expect(ticksOf(short, 7).length).toBeGreaterThan(3);
    // When it came too late, the axis shows since when; and so it does while it is still to come.
    expect(dueOnAxis(450, 500)).toBe(450);
    expect(dueOnAxis(4000, null)).toBe(4000);
  });

  test("has round ticks, and never too many", () => {
    expect(ticksOf({ fromS: 95, toS: 400 }, 8)).toEqual([120, 180, 240, 300, 360]);
    for (const lengthS of [60, 500, 4000, 90_000, 4_000_000]) {
      const ticks = ticksOf({ fromS: 1_893_456_007, toS: 1_893_456_007 + lengthS }, 8);
      expect(ticks.length).toBeLessThanOrEqual(9);
      expect(ticks.length).toBeGreaterThan(0);
    }
  });
});

describe("the signs at the head of the axis", () => {
  const span = { fromS: 0, toS: 1000 };

  test("are now and due, on one line where there is room for both", () => {
    expect(signsOf(span, 100, 900)).toEqual([{ kind: "now", atS: 100, row: 0 }, { kind: "due", atS: 900, row: 0 }]);
    expect(signsOf(span, 600, 700)).toEqual([{ kind: "now", atS: 600, row: 0 }, { kind: "due", atS: 700, row: 1 }]);
    expect(signsOf(span, 100, null)).toEqual([{ kind: "now", atS: 100, row: 0 }]);
  });

  test("leave now out where the order has ended", () => {
    expect(signsOf(span, Infinity, 700)).toEqual([{ kind: "due", atS: 700, row: 0 }]);
    expect(signsOf(span, Infinity, null)).toEqual([]);
  });

  test("are in the legend, as is the expected range, where they are drawn", () => {
    const bars = ["fetch", "carry", "lost", "waits", "made"];
    expect(legendOf(false, true, true)).toEqual([...bars, "open", "expected", "now", "due"]);
    expect(legendOf(true, false, false)).toEqual(bars);
  });
});

test("the expected range is one bar from the earliest to the latest", () => {
  expect(barsOfExpected({ from_at_s: 300, to_at_s: 400 }, 200)).toEqual([{ kind: "expected", fromS: 300, toS: 400 }]);
  expect(barsOfExpected({ from_at_s: 300, to_at_s: 290 }, 200)).toEqual([{ kind: "expected", fromS: 300, toS: 300 }]);
  // Nothing is expected in the past.
  expect(barsOfExpected({ from_at_s: 300, to_at_s: 400 }, 350)).toEqual([{ kind: "expected", fromS: 350, toS: 400 }]);
  expect(barsOfExpected({ from_at_s: 300, to_at_s: 400 }, 500)).toEqual([{ kind: "expected", fromS: 500, toS: 500 }]);
  expect(barsOfExpected(null, 200)).toEqual([]);
});

describe("in words", () => {
  test("a transport says who was replaced, and who goes on", () => {
    const legs = [leg({ carrier: "ATV3", until_at_s: 220, replaced: "silent" }), leg({ aboard_at_s: 240 })];
    expect(transportText(transport(legs), 400)).toMatch(/^ATV3 was replaced at .+: silent\. ATV1 carries it since .+\.$/);
    expect(transportText(transport([]), 400)).toBe("Nobody carries it yet.");
    // Of last Tuesday the hour alone says nothing.
    expect(transportText(transport([leg({ until_at_s: 210 })]), 210 + 5 * 86_400)).toMatch(/^ATV1 handed it over at OUT at [A-Z][a-z]{2} \d\d:\d\d\./);
    expect(transportText(transport([leg({ until_at_s: 210, replaced: "silent" })]), 400)).toContain("Nobody carries it yet.");
    expect(transportText(transport([], { outcome: "withdrawn", closed_at_s: 300 }), 400)).toBe("It was withdrawn.");
    const under = transport([leg({ carrier: "ATV1", aboard_at_s: 240, until_at_s: 300 })], { outcome: "withdrawn", closed_at_s: 300 });
    expect(transportText(under, 400)).toMatch(/^ATV1 worked on it until .+\. It was withdrawn\.$/);
  });

  test("an event says why", () => {
    const moment = { kind: "took_over" as const, at_s: 1, task: "t", goal: "g", agent: "ATV1", other: "ATV3", item: "g2", quantity: 20, thing: "", reason: "silent", silent_s: 5.5 };
    expect(momentText(moment)).toMatch(/^ATV1 took 20 g2 over from ATV3: silent for 5\.5/);
    expect(momentText({ ...moment, reason: "", silent_s: null })).toBe("ATV1 took 20 g2 over from ATV3");
    expect(momentText({ ...moment, item: ".thing", quantity: 1, thing: "pump housing", reason: "", silent_s: null })).toBe("ATV1 took pump housing over from ATV3");
  });
});
