/** One auction as it is shown: who bid what, who refused, which one is meant. Pure. */
import type { BidView, RefusalView, TaskView } from "../../api/types";
import type { Selection } from "../../selection/selection";
import type { World } from "../../stream/world";

export interface BidRow {
  readonly bid: BidView;
  readonly standing: "primary" | "secondary" | null;
}

export interface Auction {
  /** The carrier first, then by price; bids for the watch alone come last. */
  readonly rows: readonly BidRow[];
  readonly refusals: readonly RefusalView[];
  /** The dearest bid: what a full bar stands for. */
  readonly mostS: number;
  /** The parts of the prices, in the order in which they are spent. */
  readonly parts: readonly string[];
}

/** A part that nobody spends half a second on is not worth a place in the legend. */
const SHOWN_S = 0.5;
const PART_ORDER = ["empty_way", "loaded_way", "energy", "suitability", "queue", "material", "making"];

export function auctionOf(task: TaskView): Auction {
  const rows = latestBids(task.bids).map((bid) => ({ bid, standing: standingOf(task, bid.bidder) }));
  rows.sort((a, b) => rank(a) - rank(b) || a.bid.total_s - b.bid.total_s);
  const bidders = new Set(rows.map(({ bid }) => bid.bidder));
  return {
    rows,
    // Who refused a first round and bid in a wider one is a bidder now.
    refusals: latestRefusals(task.refusals).filter(({ agent }) => !bidders.has(agent)),
    mostS: Math.max(1, ...rows.map(({ bid }) => bid.total_s)),
    parts: partsOf(rows),
  };
}

/**
 * A bid for the carriage counts before a bid for the watch; a later one before an earlier one. What was
 * bid for the carriage before the task was announced anew counts no more.
 */
export function latestBids(bids: readonly BidView[]): BidView[] {
  const epoch = Math.max(0, ...bids.filter(({ role }) => role === "primary").map((bid) => bid.epoch));
  const byBidder = new Map<string, BidView>();
  for (const bid of bids) {
    if (bid.role === "primary" && bid.epoch < epoch) continue;
    const known = byBidder.get(bid.bidder);
    if (known?.role === "primary" && bid.role === "secondary") continue;
    byBidder.set(bid.bidder, bid);
  }
  return [...byBidder.values()];
}

function latestRefusals(refusals: readonly RefusalView[]): RefusalView[] {
  return [...new Map(refusals.map((refusal) => [refusal.agent, refusal])).values()];
}

function standingOf(task: TaskView, agent: string): BidRow["standing"] {
  if (agent === task.primary) return "primary";
  return agent === task.secondary ? "secondary" : null;
}

/** Who only bid for the watch did not compete for the carriage. */
function rank({ bid, standing }: BidRow): number {
  if (standing === "primary") return 0;
  return standing === "secondary" || bid.role === "primary" ? 1 : 2;
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
