"""Why was this contractor chosen? Answered from the task's own record of bids only.

A coordinator asks its bidders in the order of their prices until one accepts
(`dray.protocol.contract_net.auction`). The chosen bidder was the cheapest one left. Every cheaper bidder
either gave no contract when asked, or bid after the window and was never asked. Pure.
"""

from __future__ import annotations

from dray.gateway.live.projection.auctions.why_text import brief, why_text
from dray.gateway.live.views import (
    BidView,
    CarrierView,
    PassedView,
    RefusalView,
    RefusedView,
    TaskView,
    WhyView,
)
from dray.messages import Refusal
from dray.protocol.contract_net.auction_rules import rank

TIE_S = 0.05
"""Price difference in seconds that figures with one decimal do not show."""

MOST_FRAC = 0.6
"""Minimum share of the price difference for which a part of the price is called the reason."""

ACCEPTED, ASKED, SILENT, LATE, QUEUE = "accepted", "asked", "silent", "late", "queue"


def why_of(task: TaskView) -> WhyView:
    """The reason, as far as the record tells it.

    Args:
        task: its present state; its own `why` is not read.
    """
    why = _reason(task)
    why.coordinator = task.coordinator
    why.round, why.radius_m = task.round, task.radius_m
    why.text = why_text(why)
    return why


def _reason(task: TaskView) -> WhyView:
    carrier = _carrier(task)
    if task.state == "withdrawn":
        return WhyView(kind="withdrawn", agent=task.coordinator)
    if not task.primary:
        return _undecided(task, carrier)
    if carrier is not None and carrier.how == "recovered":
        return WhyView(kind="recovered", agent=task.primary)
    why = _taken_over(task, carrier) if carrier is not None and carrier.how == "took_over" else _won(task)
    if carrier is not None:
        why.replaced, why.reason, why.silent_s = carrier.replaced, carrier.reason, carrier.silent_s
    return why


def _carrier(task: TaskView) -> CarrierView | None:
    """The newest line of the carriers, if it describes the present state."""
    last = task.carriers[-1] if task.carriers else None
    return last if last is not None and last.epoch == task.epoch and last.carrier == task.primary else None


# --- nobody yet ------------------------------------------------------------------------------------


def _undecided(task: TaskView, carrier: CarrierView | None) -> WhyView:
    bids = _bids(task, task.epoch)
    refused = _refused(task, task.epoch, {bid.bidder for bid in bids})
    # Bidders asked in vain are out until they bid again.
    left = [bid for bid in bids if bid.answer in {"", ASKED}]
    why = WhyView(kind="waiting", refused=refused, bidders=len(bids), left=len(left))
    why.passed = tuple(_passed(task, bid, left[0] if left else bid) for bid in bids if bid not in left)
    if left:
        best = next((bid for bid in left if bid.answer == ASKED), left[0])
        why.kind = "asked" if best.answer == ASKED else "leading"
        why.agent, why.total_s = best.bidder, best.total_s
    if carrier is not None:
        why.replaced, why.reason, why.silent_s = carrier.replaced, carrier.reason, carrier.silent_s
    return why


# --- somebody --------------------------------------------------------------------------------------


def _taken_over(task: TaskView, carrier: CarrierView) -> WhyView:
    return WhyView(kind="took_over", agent=task.primary, confirmed=carrier.confirmed)


def _won(task: TaskView) -> WhyView:
    bids = _bids(task, task.epoch)
    won = next((bid for bid in bids if bid.bidder == task.primary), None)
    if won is None:
        return WhyView(kind="unknown", agent=task.primary)
    before = bids[: bids.index(won)]
    after = bids[len(before) + 1 :]
    rivals = [bid for bid in after if bid.answer not in {SILENT, LATE} and not _declined(bid)]
    why = WhyView(
        kind="cheapest" if rivals else "only",
        agent=won.bidder,
        total_s=won.total_s,
        bidders=len(bids),
        left=1 + len(rivals),
        passed=tuple(_passed(task, bid, won) for bid in before),
        refused=_refused(task, task.epoch, {bid.bidder for bid in bids}),
    )
    if rivals:
        _compare(why, won, rivals[0])
    return why


def _compare(why: WhyView, won: BidView, other: BidView) -> None:
    """Note how the winner beat the next bidder."""
    why.other, why.by_s = other.bidder, other.total_s - won.total_s
    if why.by_s < TIE_S:
        why.kind = "tie"
        if why.by_s > 0:
            why.tie_by = "price"
        else:
            why.tie_by = "finish" if won.finish_at_s < other.finish_at_s else "name"
        return
    less_s = {name: seconds - won.parts_s.get(name, 0.0) for name, seconds in other.parts_s.items()}
    part, most_s = max(less_s.items(), key=lambda each: each[1], default=("", 0.0))
    if most_s >= MOST_FRAC * why.by_s:
        why.part, why.part_s = part, most_s


def _passed(task: TaskView, bid: BidView, won: BidView) -> PassedView:
    answer = bid.answer or LATE
    if answer == "busy" and task.kind == "production":
        answer = QUEUE  # A machine works at one goal after another: others came before this one.
    less_s = won.total_s - bid.total_s
    return PassedView(
        agent=bid.bidder, less_s=less_s if less_s >= TIE_S else 0.0, answer=answer, taken_for=bid.taken_for
    )


# --- the record ------------------------------------------------------------------------------------


def _bids(task: TaskView, epoch: int) -> list[BidView]:
    """The last bid of every bidder for the contract itself, in the order in which they are asked."""
    last = {bid.bidder: bid for bid in task.bids if bid.role == "primary" and bid.epoch == epoch}
    return sorted(last.values(), key=lambda bid: rank(bid.total_s, bid.finish_at_s, bid.bidder))


def _declined(bid: BidView) -> bool:
    return bid.answer not in {"", ACCEPTED, ASKED, SILENT}


def _refused(task: TaskView, epoch: int, bidders: set[str]) -> tuple[RefusedView, ...]:
    """The last refusal of every agent without a bid, by reason; the most frequent reason first.

    Those that take no work at all are told apart by what keeps them from it: a stop is another reason than the reserve.
    """
    last = {
        refusal.agent: refusal
        for refusal in task.refusals
        if refusal.role == "primary" and refusal.epoch == epoch and refusal.agent not in bidders
    }
    groups: dict[tuple[str, str], list[RefusalView]] = {}
    for agent in sorted(last):
        refusal = last[agent]
        cause = brief(refusal.detail) if refusal.reason == Refusal.NOT_FIT else ""
        groups.setdefault((refusal.reason, cause), []).append(refusal)
    ranked = sorted(groups.items(), key=lambda each: (-len(each[1]), each[0]))
    return tuple(
        RefusedView(
            reason=reason,
            agents=tuple(refusal.agent for refusal in group),
            detail=group[0].detail if cause else "",
        )
        for (reason, cause), group in ranked
    )
