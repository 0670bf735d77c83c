/** One auction as it is shown: who bid what, who refused, which one is meant. Pure. */
import type { BidView, RefusalView, TaskView } from "../../../api/types";
import type { Selection } from "../../../selection/selection";
import type { World } from "../../../stream/world";

export interface BidRow {
  readonly bid: BidView;
  readonly standing: "primary" | "secondary" | null;
}

export interface Auction {
  /** What was bid for the contract: the carrier first, then by price. The sentence about it speaks of these. */
  readonly rows: readonly BidRow[];
  /** What was bid later for the watch over it, by price: another auction, in which nobody competed for the contract. */
  readonly watch: readonly BidRow[];
  /** Of the contract. */
  readonly refusals: readonly RefusalView[];
  /** The dearest bid: what a full bar stands for. */
  readonly mostS: number;
  /** The parts of the prices, in the order in which they are spent. */
  readonly parts: readonly string[];
}

/** A part that nobody spends half a second on is not worth a place in the legend. */
const SHOWN_S = 0.5;
const PART_ORDER = ["empty_way", "loaded_way", "energy", "suitability", "waiting", "reliability", "queue", "material", "making"];

export function auctionOf(task: TaskView): Auction {
  const rowsOf = (bids: readonly BidView[]): BidRow[] =>
    bids
      .map((bid) => ({ bid, standing: standingOf(task, bid.bidder) }))
      .sort((a, b) => Number(b.standing === "primary") - Number(a.standing === "primary") || a.bid.total_s - b.bid.total_s);
  const rows = rowsOf(latestBids(task.bids));
  const bidders = new Set(rows.map(({ bid }) => bid.bidder));
  const epoch = epochOf([...task.bids, ...task.refusals]);
  const newest = Math.max(epoch, ...task.bids.map((bid) => bid.epoch));
  return {
    rows,
    // Whoever bid for both is among the rows, with its price for the contract.
    watch: rowsOf(latestOf(task.bids, "secondary", newest)).filter(({ bid }) => !bidders.has(bid.bidder)),
    // Who refused a first round and bid in a wider one is a bidder now.
    refusals: latestRefusals(task.refusals, epoch).filter(({ agent }) => !bidders.has(agent)),
    mostS: Math.max(1, ...rows.map(({ bid }) => bid.total_s)),
    parts: partsOf(rows),
  };
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

function taskOf(world: World, selection: Selection, tasks: readonly TaskView[]): TaskView | null {
  const { latest, task, atv, place } = selection;
  if (latest === "task") return world.tasks.get(task ?? "") ?? null;
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

export function isOpen(task: TaskView): boolean {
  return task.state === "bidding" || task.state === "contracted";
}

export function newest(tasks: readonly TaskView[]): TaskView | null {
  return tasks.reduce<TaskView | null>(
    (best, task) => (best === null || task.opened_at_s >= best.opened_at_s ? task : best),
    null,
  );
}
