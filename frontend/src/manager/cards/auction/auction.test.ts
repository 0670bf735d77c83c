import { readFileSync } from "node:fs";
import { describe, expect, test } from "vitest";
import type { AtvView, BidView, RefusalView, TaskView, WhyView } from "../../../api/types";
import { NOTHING, type Selection } from "../../../selection/selection";
import type { World } from "../../../stream/world";
import { auctionOf, barOf, OTHER, PART_ORDER, shownTask } from "./auction";
import { whyText } from "./why-text";
import { taskTimes } from "./times";

const NO_REASON: WhyView = {
  kind: "waiting", agent: "", total_s: 0, bidders: 0, left: 0, other: "", by_s: 0, part: "", part_s: 0, tie_by: "",
  passed: [], refused: [], round: 1, radius_m: 25, replaced: "", reason: "", silent_s: 0, confirmed: true,
  coordinator: "M8", text: "",
};
const bid = (bidder: string, empty_way: number, loaded_way = 40, more: Partial<BidView> = {}): BidView => ({
  bidder, role: "primary", epoch: 1, round: 1, total_s: empty_way + loaded_way, parts_s: { empty_way, loaded_way },
  finish_at_s: 0, source: "S4", battery_reckoned: false, answer: "", taken_for: "", ...more,
});
const refusal = (agent: string, reason: string, more: Partial<RefusalView> = {}): RefusalView => ({
  agent, role: "primary", epoch: 1, round: 1, reason, detail: "", ...more,
});
const task = (more: Partial<TaskView>): TaskView => ({
  id: "M8-214", kind: "transport", coordinator: "M8", item: "housing", quantity: 60, sources: ["S4"], source: "S4",
  destination: "M8", order: "", goal: "", epoch: 1, round: 1, radius_m: 30, state: "contracted", phase: "", goods_aboard: false,
  primary: "", secondary: "", opened_at_s: 0, contracted_at_s: null, promised_at_s: null, deadline_at_s: 100,
  closed_at_s: null, trouble: null, fails_at: "", stranded: null, carriers: [], bids: [], refusals: [],
  why: NO_REASON, ...more,
});

describe("an auction", () => {
  test("shows the carrier first, then by price", () => {
    const { rows } = auctionOf(task({ primary: "C", secondary: "A", bids: [bid("B", 30), bid("A", 10), bid("C", 20)] }));
    expect(rows.map((row) => [row.bid.bidder, row.standing])).toEqual([
      ["C", "primary"], ["A", "secondary"], ["B", null],
    ]);
  });

  test("crowns nobody who took over: whoever won was the cheapest of those that are compared", () => {
    const why = { ...NO_REASON, kind: "took_over", agent: "C", replaced: "A" } as const;
    const { rows } = auctionOf(task({ primary: "C", why, bids: [bid("B", 30), bid("A", 10), bid("C", 20)] }));
    expect(rows.map((row) => [row.bid.bidder, row.standing])).toEqual([["A", null], ["C", "primary"], ["B", null]]);
  });

  test("shows no price for the watch beside those for the contract: nobody else bid for that", () => {
    const bids = [bid("ATV2", 54.8, 0), bid("ATV3", 20, 0, { role: "secondary" }), bid("ATV1", 10, 0, { role: "secondary" })];
    const { rows, watch } = auctionOf(task({ primary: "ATV2", secondary: "ATV1", bids }));
    expect(rows.map((row) => row.bid.bidder)).toEqual(["ATV2"]);
    expect(watch.map((row) => [row.bid.bidder, row.standing])).toEqual([["ATV1", "secondary"], ["ATV3", null]]);
  });

  test("shows first who watches now, whoever bid less for a watch that has ended", () => {
    const watches = [bid("ATV3", 20, 0, { role: "secondary", answer: "accepted" }), bid("ATV1", 90, 0, { role: "secondary", answer: "accepted" })];
    const { watch } = auctionOf(task({ primary: "ATV2", secondary: "ATV1", bids: [bid("ATV2", 54.8, 0), ...watches] }));
    expect(watch.map((row) => row.bid.bidder)).toEqual(["ATV1", "ATV3"]);
  });

  test("counts a refusal to watch as none of the contract", () => {
    const refusals = [refusal("A", "busy"), refusal("B", "busy", { role: "secondary" }), refusal("C", "battery")];
    expect(auctionOf(task({ bids: [bid("D", 1)], refusals })).refusals.map(({ agent }) => agent)).toEqual(["A", "C"]);
    const anew = auctionOf(task({ epoch: 2, bids: [bid("D", 1, 1, { epoch: 2 })], refusals }));
    expect(anew.refusals).toEqual([]);
  });

  test("counts nobody as refusing who is busy and offers to watch: neither in the list nor in the sentence above it", () => {
    const bids = [bid("D", 1), bid("A", 2, 0, { role: "secondary" })];
    const refused = [{ reason: "busy", agents: ["A", "B"], detail: "" }];
    const shown = task({
      primary: "D", bids, refusals: [refusal("A", "busy"), refusal("B", "busy")],
      why: { ...NO_REASON, kind: "only", agent: "D", total_s: 1, bidders: 1, left: 1, refused },
    });
    expect(auctionOf(shown).refusals.map(({ agent }) => agent)).toEqual(["B"]);
    expect(whyText(shown)).toContain("B refused");
    expect(whyText(shown)).not.toContain("2 refused");
  });

  test("counts a bidder once, with its latest bid for the transport", () => {
    const bids = [bid("A", 50), bid("A", 30, 40, { round: 2 }), bid("A", 1, 1, { role: "secondary" })];
    expect(auctionOf(task({ bids })).rows.map((row) => row.bid.total_s)).toEqual([70]);
  });


  test("leaves out what was bid before the task was announced anew", () => {
    const bids = [bid("A", 1), bid("B", 30, 40, { epoch: 2 }), bid("C", 1, 1, { role: "secondary" })];
    expect(auctionOf(task({ epoch: 2, bids })).rows.map((row) => row.bid.bidder)).toEqual(["B"]);
    expect(auctionOf(task({ epoch: 2, bids })).watch).toEqual([]);
  });

  test("forgets the refusal of who bid in a later round", () => {
    const { refusals } = auctionOf(
      task({ bids: [bid("A", 1, 1, { round: 2 })], refusals: [refusal("A", "out_of_radius"), refusal("B", "busy")] }),
    );
    expect(refusals.map(({ agent }) => agent)).toEqual(["B"]);
  });

  test("names the parts in the order in which they are spent, and none that nobody spends", () => {
    const parts_s = { suitability: 0, energy: 3, loaded_way: 2, empty_way: 1 };
    expect(auctionOf(task({ bids: [bid("A", 1, 1, { parts_s })] })).parts).toEqual(["empty_way", "loaded_way", "energy"]);
  });
});

describe("the bar of a bid", () => {
  const css = readFileSync(new URL("../../../styles/cards/auction.css", import.meta.url), "utf8");

  test("is as long as its price, whatever the price is made of", () => {
    const prices = [
      { empty_way: 20, loaded_way: 40, waiting: 32 }, { empty_way: 91.8, energy: 0.2 }, { queue: 0.4, making: 91.6 },
      { empty_way: 30, unheard_of: 62 },
    ];
    const bids = prices.map((parts_s, i) => bid(`ATV${i}`, 0, 0, { parts_s, total_s: 92 }));
    const { mostS, parts } = auctionOf(task({ bids }));
    const lengths = bids.map((each) => barOf(each, parts, mostS).reduce((sum, { frac }) => sum + frac, 0));
    for (const length of lengths) expect(length).toBeCloseTo(1, 9);
  });

  test("has a part for what no legend names, and none for nothing", () => {
    expect(barOf({ parts_s: { making: 4 }, total_s: 5 }, ["making"], 10)).toEqual([{ part: "making", frac: 0.4 }, { part: OTHER, frac: 0.1 }]);
    expect(barOf({ parts_s: { making: 5 }, total_s: 5 }, ["making", "rest"], 10)).toEqual([{ part: "making", frac: 0.5 }]);
  });

  test.each([...PART_ORDER, OTHER])("has a look for %s", (part) => {
    expect(css).toMatch(new RegExp(`\\.part-${part}[,\\s][^}]*background: `));
  });
});

describe("the shown auction", () => {
  const older = task({ id: "M8-1", opened_at_s: 1, primary: "ATV1", bids: [bid("ATV1", 1)] });
  const newer = task({ id: "M9-2", opened_at_s: 2, coordinator: "M9", primary: "ATV2", bids: [bid("ATV2", 1)] });
  const atv = { id: "ATV1", task: { task: "M8-1" } } as AtvView;
  const world = {
    tasks: new Map([older, newer].map((each) => [each.id, each])),
    atvs: new Map([["ATV1", atv]]),
  } as unknown as World;
  const chosen = (more: Partial<Selection>): Selection => ({ ...NOTHING, ...more });

  test("is the newest as long as nothing is chosen", () => {
    expect(shownTask(world, NOTHING, "chosen")?.id).toBe("M9-2");
  });

  test("follows the vehicle, the machine or the task chosen last", () => {
    expect(shownTask(world, chosen({ atv: "ATV1", latest: "atv" }), "chosen")?.id).toBe("M8-1");
    const place = { kind: "machine", id: "M8" } as const;
    expect(shownTask(world, chosen({ atv: "ATV2", place, latest: "machine" }), "chosen")?.id).toBe("M8-1");
    expect(shownTask(world, chosen({ task: "M8-1", latest: "task" }), "chosen")?.id).toBe("M8-1");
  });

  test("is nobody else's where the chosen one has none", () => {
    const place = { kind: "machine", id: "M1" } as const;
    expect(shownTask(world, chosen({ place, latest: "machine" }), "chosen")).toBeNull();
  });

  test("is the newest again where a person asks for it", () => {
    expect(shownTask(world, chosen({ atv: "ATV1", latest: "atv" }), "newest")?.id).toBe("M9-2");
  });
});

test("the ledger compares delivery and promise in factory time", () => {
  const times = taskTimes(task({ state: "delivered", closed_at_s: 12, promised_at_s: 10 }), 10);
  expect(times[1]).toBe("20\u202fs of factory time after the promise");
});
