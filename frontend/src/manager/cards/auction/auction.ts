/** One auction as it is shown: who bid what, who refused, which one is meant. Pure. */
import type { BidView, RefusalView, TaskView } from "../../../api/types";
import type { Selection } from "../../../selection/selection";
import type { World } from "../../../stream/world";

export interface BidRow {
  readonly bid: BidView;
  readonly standing: "primary" | "secondary" | null;
}

export interface Auction {
  /**
   * What was bid for the contract, by price, and first of all who won it. The sentence about it speaks of these. Who has taken
   * over has won no auction: its price then stands where it stood.
   */
  readonly rows: readonly BidRow[];
  /**
   * What was bid later for the watch over it, by price, and first of all who has it: another auction, in which
   * nobody competed for the contract. A watch that ends is put up again: whoever had it before is among them.
   */
  readonly watch: readonly BidRow[];
  /** Of the contract. */
  readonly refusals: readonly RefusalView[];
  /** The dearest bid: what a full bar stands for. */
  readonly mostS: number;
  /** The parts of the prices, in the order in which they are spent. */
  readonly parts: readonly string[];
}

/** A part that nobody spends half a second on is not worth a place in the legend: it is among the rest. */
const SHOWN_S = 0.5;
/** What a price has beside the parts in the legend. */
export const OTHER = "other";
export const PART_ORDER = ["empty_way", "loaded_way", "energy", "suitability", "waiting", "reliability", "queue", "material", "making", "rest", "passed"];

export function auctionOf(task: TaskView): Auction {
  const hasWon = isWon(task);
  const rowsOf = (bids: readonly BidView[]): BidRow[] =>
    bids
      .map((bid) => ({ bid, standing: standingOf(task, bid.bidder) }))
      .sort((a, b) => (hasWon ? Number(b.standing === "primary") - Number(a.standing === "primary") : 0) || a.bid.total_s - b.bid.total_s);
  const rows = rowsOf(latestBids(task.bids));
  const bidders = new Set(rows.map(({ bid }) => bid.bidder));
  const epoch = epochOf([...task.bids, ...task.refusals]);
  const newest = Math.max(epoch, ...task.bids.map((bid) => bid.epoch));
  return {
    rows,
    // Whoever bid for both is among the rows, with its price for the contract.
    watch: rowsOf(latestOf(task.bids, "secondary", newest))
      .filter(({ bid }) => !bidders.has(bid.bidder))
      .sort((a, b) => Number(b.standing === "secondary") - Number(a.standing === "secondary")),
    // Who refused a first round and bid in a wider one is a bidder now; who carries something else and offers to watch has not refused.
    refusals: latestRefusals(task.refusals, epoch).filter(({ agent }) => !bidders.has(agent) && !watchers(task).has(agent)),
    mostS: Math.max(1, ...rows.map(({ bid }) => bid.total_s)),
    parts: partsOf(rows),
  };
}

/** Whether the carrier is the one that the auction ended with. */
export function isWon({ why }: Pick<TaskView, "why">): boolean {
  return why.kind !== "took_over" && why.kind !== "recovered";
}

/** Who has offered to watch over it, or does so: busy with something else, and no less willing. */
export function watchers({ bids, secondary }: Pick<TaskView, "bids" | "secondary">): ReadonlySet<string> {
  const newest = Math.max(0, ...bids.map((bid) => bid.epoch));
  return new Set([secondary, ...latestOf(bids, "secondary", newest).map(({ bidder }) => bidder)].filter((each) => each !== ""));
}

/** The last bid of everybody for the contract. What was bid before the task was announced anew counts no more. */
export function latestBids(bids: readonly BidView[]): BidView[] {
  return latestOf(bids, "primary", epochOf(bids));
}

/** The newest epoch in which the contract was put up for auction. */
function epochOf(said: readonly Pick<BidView, "role" | "epoch">[]): number {
  return Math.max(0, ...said.filter(({ role }) => role === "primary").map(({ epoch }) => epoch));
}

function latestOf(bids: readonly BidView[], role: BidView["role"], epoch: number): BidView[] {
  const meant = bids.filter((bid) => bid.role === role && bid.epoch === epoch);
  return [...new Map(meant.map((bid) => [bid.bidder, bid])).values()];
}

function latestRefusals(refusals: readonly RefusalView[], epoch: number): RefusalView[] {
  const meant = refusals.filter((refusal) => refusal.role === "primary" && refusal.epoch === epoch);
  return [...new Map(meant.map((refusal) => [refusal.agent, refusal])).values()];
}

function standingOf(task: TaskView, agent: string): BidRow["standing"] {
  if (agent === task.primary) return "primary";
  return agent === task.secondary ? "secondary" : null;
}

/** One part of a bar: what it stands for, and how much of the longest bar it takes. */
export interface BarPart {
  readonly part: string;
  readonly frac: number;
}

/**
 * What is drawn of a bid. Together it is as long as the price: whatever is summed and not in the legend is one part at the end.
 *
 * @param mostS what a full bar stands for
 */
export function barOf({ parts_s: partsS, total_s: totalS }: Pick<BidView, "parts_s" | "total_s">, parts: readonly string[], mostS: number): BarPart[] {
  const drawn = parts.map((part) => ({ part, s: Math.max(0, partsS[part] ?? 0) }));
  const other = totalS - drawn.reduce((sum, { s }) => sum + s, 0);
  const all = other > 0 ? [...drawn, { part: OTHER, s: other }] : drawn;
  return all.filter(({ s }) => s > 0).map(({ part, s }) => ({ part, frac: s / mostS }));
}

function partsOf(rows: readonly BidRow[]): string[] {
  const spent = rows.flatMap(({ bid }) => Object.entries(bid.parts_s).filter(([, s]) => s >= SHOWN_S));
  const names = new Set(spent.map(([name]) => name));
  const known = PART_ORDER.filter((name) => names.delete(name));
  return [...known, ...names];
}

/**
 * The task whose auction is shown: that of the chosen one, or the newest. Null where the chosen one
 * has none: another one's auction would be taken for its own.
 */
export function shownTask(world: World, selection: Selection, follow: "chosen" | "newest"): TaskView | null {
  const tasks = [...world.tasks.values()];
  if (follow === "chosen" && selection.latest !== null) return taskOf(world, selection, tasks);
  const auctioned = tasks.filter((task) => task.bids.length > 0);
  return newest(auctioned) ?? newest(tasks);
}

/** The task of what was chosen last, an open one rather than another. */
export function taskOf(world: World, selection: Selection, tasks: readonly TaskView[] = [...world.tasks.values()]): TaskView | null {
  const { latest, task, atv, order, place } = selection;
  if (latest === "task") return world.tasks.get(task ?? "") ?? null;
  if (latest === "order") {
    const own = tasks.filter((each) => orderOf(world, each) === order);
    const transports = own.filter((each) => each.kind === "transport");
    return newest(transports.filter(isOpen)) ?? newest(own.filter(isOpen)) ?? newest(own);
  }
  if (latest === "atv" && atv !== null) {
    const own = world.tasks.get(world.atvs.get(atv)?.task?.task ?? "");
    return own ?? newest(tasks.filter((each) => each.primary === atv || each.secondary === atv));
  }
  const id = place?.id ?? "";
  const open = tasks.filter((each) => each.coordinator === id && each.kind === "transport");
  return (
    newest(open.filter(isOpen)) ??
    newest(open) ??
    newest(tasks.filter((each) => each.source === id || each.destination === id))
  );
}

/** For which order something is carried or made; null for material. */
export function orderOf(world: World, task: TaskView): string | null {
  const order = task.order === "" ? (world.tasks.get(task.goal)?.order ?? "") : task.order;
  return order === "" ? null : order;
}

export function isOpen(task: TaskView): boolean {
  return task.state === "bidding" || task.state === "contracted";
}

export function newest(tasks: readonly TaskView[]): TaskView | null {
  return tasks.reduce<TaskView | null>(
    (best, task) => (best === null || task.opened_at_s >= best.opened_at_s ? task : best),
    null,
  );
}
