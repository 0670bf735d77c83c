/**
 * "Why this vehicle?", answered from the bids alone: nothing is said here that the record does not
 * show. Pure; the words are put to it in `why-text`.
 */
import type { BidView, TaskView } from "../../api/types";
import { auctionOf, latestBids } from "./auction";

export type Why =
  | { kind: "waiting"; refused: number }
  | { kind: "leading"; bidder: string; totalS: number }
  | { kind: "withdrawn"; coordinator: string }
  | { kind: "only"; winner: string }
  | { kind: "part"; winner: string; other: string; part: string; byS: number }
  | { kind: "total"; winner: string; other: string; byS: number }
  | { kind: "tie"; winner: string; other: string }
  | { kind: "cheaperDeclined"; winner: string; other: string; byS: number; reason: string }
  | { kind: "cheaperSilent"; winner: string; other: string; byS: number }
  | { kind: "cheaperAsked"; winner: string; other: string; byS: number }
  | { kind: "replaced"; winner: string; before: string; reason: string; silentS: number }
  | { kind: "tookOver"; winner: string; before: string; epoch: number }
  | { kind: "unknown"; winner: string };

/** A difference below half a second is rounded away on the screen, and so no reason. */
const TIE_S = 0.5;
/** A part is called the reason only where it makes up most of the difference. */
const MOST = 0.6;

export function whyOf(task: TaskView): Why {
  const { rows, refusals } = auctionOf(task);
  const cheapest = byPrice(latestBids(task.bids));
  if (task.state === "withdrawn") return { kind: "withdrawn", coordinator: task.coordinator };
  if (task.primary === "") {
    const best = cheapest[0];
    if (!best) return { kind: "waiting", refused: refusals.length };
    return { kind: "leading", bidder: best.bidder, totalS: best.total_s };
  }
  const winner = task.primary;
  const taken = task.carriers.at(-1);
  if (taken?.carrier === winner && taken.replaced !== "") {
    return { kind: "replaced", winner, before: taken.replaced, reason: taken.reason, silentS: taken.silent_s };
  }
  const before = task.epoch > 1 ? wonBefore(task, cheapest) : null;
  if (before) return { kind: "tookOver", winner, before: before.bidder, epoch: task.epoch };
  const won = rows.find(({ bid }) => bid.bidder === winner)?.bid;
  if (!won) return { kind: "unknown", winner };
  const best = cheapest.find(({ bidder }) => bidder !== winner);
  if (!best) return { kind: "only", winner };
  const byS = best.total_s - won.total_s;
  if (Math.abs(byS) < TIE_S) return { kind: "tie", winner, other: best.bidder };
  return byS > 0 ? becauseCheapest(won, best, byS) : becauseNotTaken(winner, best, -byS);
}

/** Who had accepted the task before its carrier changed. */
function wonBefore(task: TaskView, cheapest: readonly BidView[]): BidView | null {
  const gone = (bid: BidView): boolean => bid.bidder !== task.primary && bid.bidder !== task.secondary;
  return cheapest.find((bid) => bid.answer === "accepted" && bid.role === "primary" && gone(bid)) ?? null;
}

function becauseCheapest(won: BidView, next: BidView, byS: number): Why {
  let part = "";
  let most = 0;
  for (const [name, seconds] of Object.entries(next.parts_s)) {
    const less = seconds - (won.parts_s[name] ?? 0);
    if (less > most) [part, most] = [name, less];
  }
  const names = { winner: won.bidder, other: next.bidder };
  // Other parts may cost more, so that one part saves more than the whole difference.
  if (most >= MOST * byS && part !== "") return { kind: "part", ...names, part, byS: most };
  return { kind: "total", ...names, byS };
}

function becauseNotTaken(winner: string, cheaper: BidView, byS: number): Why {
  const base = { winner, other: cheaper.bidder, byS };
  if (cheaper.answer === "silent") return { kind: "cheaperSilent", ...base };
  if (cheaper.answer === "" || cheaper.answer === "asked" || cheaper.answer === "accepted") {
    return { kind: "cheaperAsked", ...base };
  }
  return { kind: "cheaperDeclined", ...base, reason: cheaper.answer };
}

function byPrice(bids: readonly BidView[]): BidView[] {
  return [...bids].sort((a, b) => a.total_s - b.total_s);
}
