import { describe, expect, test } from "vitest";
import type { AtvView, BidView, RefusalView, TaskView } from "../../api/types";
import { NOTHING, type Selection } from "../../selection/selection";
import type { World } from "../../stream/world";
import { auctionOf, shownTask } from "./auction";
import { taskTimes } from "./times";
import { whyOf } from "./why";
import { whyText } from "./why-text";

const bid = (bidder: string, empty_way: number, loaded_way = 40, more: Partial<BidView> = {}): BidView => ({
  bidder, role: "primary", round: 1, total_s: empty_way + loaded_way, parts_s: { empty_way, loaded_way },
  finish_at_s: 0, source: "S4", answer: "", ...more,
});
const refusal = (agent: string, reason: string, more: Partial<RefusalView> = {}): RefusalView => ({
  agent, role: "primary", round: 1, reason, detail: "", ...more,
});
const task = (more: Partial<TaskView>): TaskView => ({
  id: "M8-214", kind: "transport", coordinator: "M8", item: "housing", quantity: 60, sources: ["S4"], source: "S4",
  destination: "M8", order: "", goal: "", epoch: 1, round: 1, radius_m: 30, state: "contracted", phase: "",
  primary: "", secondary: "", opened_at_s: 0, contracted_at_s: null, promised_at_s: null, deadline_at_s: 100,
  closed_at_s: null, trouble: "", carriers: [], bids: [], refusals: [], ...more,
});

describe("an auction", () => {
  test("shows the carrier first, then by price", () => {
    const { rows } = auctionOf(task({ primary: "C", secondary: "A", bids: [bid("B", 30), bid("A", 10), bid("C", 20)] }));
    expect(rows.map((row) => [row.bid.bidder, row.standing])).toEqual([
      ["C", "primary"], ["A", "secondary"], ["B", null],
    ]);
  });

  test("counts a bidder once, with its latest bid for the carriage", () => {
    const bids = [bid("A", 50), bid("A", 30, 40, { round: 2 }), bid("A", 1, 1, { role: "secondary" })];
    expect(auctionOf(task({ bids })).rows.map((row) => row.bid.total_s)).toEqual([70]);
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

describe("why this vehicle", () => {
  test("the part that makes most of the difference is the reason", () => {
    expect(whyOf(task({ primary: "A", bids: [bid("A", 20), bid("B", 48), bid("C", 60)] }))).toEqual({
      kind: "part", winner: "A", other: "B", part: "empty_way", byS: 28,
    });
  });

  test("the total is the reason where no part is", () => {
    const why = whyOf(task({ primary: "A", bids: [bid("A", 20, 40), bid("B", 30, 50)] }));
    expect(why).toMatchObject({ kind: "total", byS: 20 });
  });

  test("a cheaper one that declined is named with its reason", () => {
    const bids = [bid("A", 20), bid("B", 5, 40, { answer: "busy" })];
    expect(whyOf(task({ primary: "A", bids }))).toEqual({
      kind: "cheaperDeclined", winner: "A", other: "B", byS: 15, reason: "busy",
    });
  });

  test("a cheaper one that kept silent is named too", () => {
    const bids = [bid("A", 20), bid("B", 5, 40, { answer: "silent" })];
    expect(whyOf(task({ primary: "A", bids })).kind).toBe("cheaperSilent");
  });

  test("after a takeover the reason is the takeover, not the price", () => {
    const bids = [bid("A", 5, 40, { answer: "accepted" }), bid("B", 30, 40, { answer: "accepted" })];
    expect(whyOf(task({ primary: "B", epoch: 2, bids }))).toEqual({ kind: "tookOver", winner: "B", before: "A", epoch: 2 });
  });

  test("after a change of carriers the record of it counts, not the bids", () => {
    const first = { carrier: "A", epoch: 1, since_at_s: 0, replaced: "", reason: "", silent_s: 0, confirmed: true };
    const second = { ...first, carrier: "B", epoch: 2, replaced: "A", reason: "silent", silent_s: 3.6 };
    const taken = task({ primary: "B", epoch: 2, bids: [bid("B", 5)], carriers: [first, second] });
    expect(whyOf(taken)).toEqual({ kind: "replaced", winner: "B", before: "A", reason: "silent", silentS: 3.6 });
    expect(whyText(taken)).toBe("B took over from A after 3.6\u202fs of silence.");
    const other = task({ primary: "B", carriers: [first, { ...second, reason: "in error" }] });
    expect(whyText(other)).toBe("B took over from A: in error.");
    // Whoever has won the task since has won it by its price.
    const won = { ...first, carrier: "C", epoch: 3 };
    expect(whyOf(task({ primary: "C", bids: [bid("C", 5)], carriers: [first, second, won] })).kind).toBe("only");
  });

  test("a single bidder won because nobody else bid", () => {
    expect(whyOf(task({ primary: "A", bids: [bid("A", 5)] }))).toEqual({ kind: "only", winner: "A" });
  });

  test("equal prices are called equal", () => {
    expect(whyOf(task({ primary: "A", bids: [bid("A", 5), bid("B", 5.2)] })).kind).toBe("tie");
  });

  test("before the award only the leader is named", () => {
    expect(whyOf(task({ state: "bidding", bids: [bid("A", 9), bid("B", 5)] }))).toMatchObject({ kind: "leading", bidder: "B" });
    expect(whyOf(task({ state: "bidding", refusals: [refusal("A", "busy")] }))).toEqual({ kind: "waiting", refused: 1 });
  });

  test("nothing is claimed of a carrier whose bid is not on record", () => {
    expect(whyOf(task({ primary: "Z", bids: [bid("A", 9)] }))).toEqual({ kind: "unknown", winner: "Z" });
  });

  test("the sentence says it in words, and who could not", () => {
    const refusals = [refusal("ATV7", "battery"), refusal("ATV2", "busy")];
    const text = whyText(task({ primary: "ATV3", bids: [bid("ATV3", 20), bid("ATV1", 48)], refusals }));
    expect(text).toBe(
      "ATV3, because its empty way costs 28\u202fs less than that of ATV1, the next cheapest. ATV7 could not: battery.",
    );
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
  expect(times[1]).toBe("20\u202fs after the promise");
});
