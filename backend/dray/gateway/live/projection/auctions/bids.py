"""The bids on one task as panels see them, and the refusals.

Facts of an epoch that is over change nothing: the functions return False.
"""

from __future__ import annotations

from typing import TypeVar

from dray.gateway.live.projection.agents.atvs import plain
from dray.gateway.live.views import BidView, RefusalView, TaskView
from dray.messages import Cost, Event, Role, TransportCost
from dray.messages.fact import AwardGiven, BidReceived, BidRefused
from dray.store.history.clocks import ToWall

S = TypeVar("S", BidView, RefusalView)

MAX_BIDS = 64
"""Maximum bids per task and role, newest last, and as many refusals: nobody reads more, and a task that waits
for days would gather them without end. Later bids for the secondary role push out none for the contract."""


def add_bid(task: TaskView, fact: BidReceived, to_wall_s: ToWall) -> bool:
    """Add a bid; it replaces the bidder's earlier bid of that round."""
    if fact.epoch < task.epoch:
        return False
    bid = BidView(
        bidder=fact.bidder,
        role=plain(fact.role),
        epoch=fact.epoch,
        round=fact.round,
        # The coordinator's rank value: with the surcharge for the bidder's reliability.
        total_s=fact.total_s + fact.surcharge_s,
        parts_s=_parts(fact.cost) | ({"reliability": fact.surcharge_s} if fact.surcharge_s else {}),
        finish_at_s=to_wall_s(fact.finish_s),
        source=fact.source,
        battery_reckoned=fact.battery_reckoned is True,
    )
    same = (fact.bidder, bid.role, fact.epoch, fact.round)
    others = [o for o in task.bids if (o.bidder, o.role, o.epoch, o.round) != same]
    task.bids = (*_newest(others, bid.role), bid)
    return True


def add_refusal(task: TaskView, event: Event, fact: BidRefused) -> bool:
    """Add a refusal with its reason."""
    if fact.epoch < task.epoch:
        return False
    refusal = RefusalView(
        agent=event.agent,
        role=plain(fact.role),
        epoch=fact.epoch,
        round=task.round,
        reason=fact.reason.value,
        detail=fact.detail,
    )
    same = (refusal.agent, refusal.role, refusal.epoch, refusal.round)
    others = [o for o in task.refusals if (o.agent, o.role, o.epoch, o.round) != same]
    task.refusals = (*_newest(others, refusal.role), refusal)
    return True


def _newest(said: list[S], role: str) -> list[S]:
    """The list without the oldest entry of this role, if it is full."""
    of_role = [place for place, each in enumerate(said) if each.role == role]
    return said if len(of_role) < MAX_BIDS else said[: of_role[0]] + said[of_role[0] + 1 :]


def note_award(task: TaskView, _event: Event, fact: AwardGiven) -> bool:
    """Note that a bidder was offered the contract."""
    bid = last_bid(task, fact.bidder, fact.role, fact.epoch)
    if fact.epoch < task.epoch or bid is None:
        return False
    bid.answer = "asked"
    return True


def last_bid(task: TaskView, bidder: str, role: Role, epoch: int) -> BidView | None:
    """The newest bid of a bidder in an epoch; None if there is none."""
    for bid in reversed(task.bids):
        if (bid.bidder, bid.role, bid.epoch) == (bidder, role.value, epoch):
            return bid
    return None


def _parts(cost: Cost) -> dict[str, float]:
    if isinstance(cost, TransportCost):
        return {
            "empty_way": cost.empty_way_s,
            "loaded_way": cost.loaded_way_s,
            "energy": cost.energy_s,
            "suitability": cost.suitability_s,
            **({"waiting": cost.waiting_s} if cost.waiting_s else {}),
        }
    return {
        "queue": cost.queue_s,
        "material": cost.material_s,
        "making": cost.making_s,
        **({"passed": cost.passed_s} if cost.passed_s else {}),
        **({"rest": cost.rest_s} if cost.rest_s else {}),
    }
