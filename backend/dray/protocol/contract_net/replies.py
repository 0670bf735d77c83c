"""A contractor's answers: a bid or a reason for none, an acceptance or a refusal. Messages only.

Vehicles (`bidding`, `atv`) and machines (`goal_bidding`) decide in their own ways and answer alike.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages import (
    Accepted,
    Award,
    Bid,
    Declined,
    ProductionCost,
    Refusal,
    Role,
    TaskAnnounced,
    TransportCost,
)
from dray.messages.fact import BidRefused, BidSent
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import Effect, Record, Send
from dray.protocol.runtime.life import Life

REFUSALS_KEPT = 256
"""Maximum remembered refusals of one contractor: more tasks are not announced around it at a time."""


def offer(
    announced: TaskAnnounced,
    cost: TransportCost | ProductionCost,
    finish_s: float,
    now_s: float,
    source: str = "",
    *,
    battery_reckoned: bool = False,
) -> tuple[Effect, ...]:
    """Bid for what was announced.

    Args:
        announced: the announcement.
        cost: the price with its parts.
        finish_s: when it would be done (plant clock).
        now_s: the present time.
        source: where the load would be fetched; empty for a goal.
        battery_reckoned: whether the bidder's battery level is estimated, not measured.
    """
    bid = Bid(
        task=announced.task,
        epoch=announced.epoch,
        role=announced.role,
        round=announced.round,
        cost=cost,
        finish_s=finish_s,
        source=source,
        at_s=now_s,
        battery_reckoned=battery_reckoned or UNSET,
    )
    sent = BidSent(task=announced.task, epoch=announced.epoch, role=announced.role, total_s=cost.total_s)
    return Send(announced.coordinator, bid), Record(sent)


class Refusals:
    """Records why a contractor did not bid, once per reason; the coordinator is not told.

    A task is announced until a contractor takes it, so the same refusal would recur every round.
    """

    def __init__(self, life: Life) -> None:
        self._life = life
        self._said: BoundedMap[tuple[str, Role], tuple[int, Refusal]] = BoundedMap(REFUSALS_KEPT)
        """By task and role: epoch and reason of the last refusal."""

    def note(self, announced: TaskAnnounced, reason: Refusal, detail: str) -> None:
        """Record why there is no bid for this announcement, once per reason."""
        key, said = (announced.task, announced.role), (announced.epoch, reason)
        if self._said.get(key) != said:
            self._said[key] = said
            refused = BidRefused(
                task=announced.task, epoch=announced.epoch, role=announced.role, reason=reason, detail=detail
            )
            self._life.record(refused)

    def forget(self, announced: TaskAnnounced) -> None:
        """Forget the refusal after a bid, so that the next refusal is recorded."""
        self._said.pop((announced.task, announced.role), None)


def accept(coordinator: str, award: Award, finish_s: float, now_s: float) -> Effect:
    """Accept an award, and promise a finish time (plant clock)."""
    accepted = Accepted(
        task=award.task,
        epoch=award.epoch,
        role=award.role,
        finish_s=finish_s,
        number=award.number,
        at_s=now_s,
    )
    return Send(coordinator, accepted)


def decline(coordinator: str, award: Award, reason: Refusal) -> Effect:
    """Decline an award: circumstances may have changed since the bid."""
    declined = Declined(
        task=award.task, epoch=award.epoch, role=award.role, reason=reason, number=award.number
    )
    return Send(coordinator, declined)
