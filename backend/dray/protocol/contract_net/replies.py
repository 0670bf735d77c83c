"""What a contractor answers: a bid or why there is none, an acceptance or a refusal. The words alone.

Vehicles (`bidding`, `atv`) and machines (`goal_bidding`) decide each in their way, and say it alike.
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
"""Tasks that one contractor has refused lately: more are not announced around it at one time."""


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
        announced: what, and by whom.
        cost: the price with its parts.
        finish_s: when it would be done (plant clock).
        now_s: the present time.
        source: where the load would be fetched; empty for a goal.
        battery_reckoned: the level of the bidder's battery is not measured.
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
    """Why one contractor did not bid, put on record once: the coordinator is not bothered with it.

    A task is announced until somebody takes it. Who goes on refusing it for the same reason has said so.
    """

    def __init__(self, life: Life) -> None:
        self._life = life
        self._said: BoundedMap[tuple[str, Role], tuple[int, Refusal]] = BoundedMap(REFUSALS_KEPT)
        """By task and role: the epoch and the reason of the last refusal."""

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
        """There is a bid for this now: another refusal would be news."""
        self._said.pop((announced.task, announced.role), None)


def accept(coordinator: str, award: Award, finish_s: float, now_s: float) -> Effect:
    """Take what was awarded, and promise when it will be done (plant clock)."""
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
    """Decline an award: the circumstances may have changed since the bid."""
    declined = Declined(
        task=award.task, epoch=award.epoch, role=award.role, reason=reason, number=award.number
    )
    return Send(coordinator, declined)
