"""What a contractor answers: a bid or why there is none, an acceptance or a refusal. The words alone.

Vehicles (`bidding`, `atv`) and machines (`goal_bidding`) decide each in their way, and say it alike.
"""

from __future__ import annotations

from dray.messages import (
    Accepted,
    Award,
    Bid,
    Declined,
    ProductionCost,
    Refusal,
    TaskAnnounced,
    TransportCost,
)
from dray.messages.fact import BidRefused, BidSent
from dray.protocol.events import Effect, Record, Send


def offer(
    announced: TaskAnnounced, cost: TransportCost | ProductionCost, finish_s: float, source: str = ""
) -> tuple[Effect, ...]:
    """Bid for what was announced.

    Args:
        announced: what, and by whom.
        cost: the price with its parts.
        finish_s: when it would be done (plant clock).
        source: where the load would be fetched; empty for a goal.
    """
    bid = Bid(
        task=announced.task,
        epoch=announced.epoch,
        role=announced.role,
        round=announced.round,
        cost=cost,
        finish_s=finish_s,
        source=source,
    )
    sent = BidSent(task=announced.task, epoch=announced.epoch, role=announced.role, total_s=cost.total_s)
    return Send(announced.coordinator, bid), Record(sent)


def refuse(announced: TaskAnnounced, reason: Refusal, detail: str) -> Effect:
    """Put on record why there is no bid; the coordinator is not bothered with it."""
    refused = BidRefused(
        task=announced.task, epoch=announced.epoch, role=announced.role, reason=reason, detail=detail
    )
    return Record(refused)


def accept(coordinator: str, award: Award, finish_s: float) -> Effect:
    """Take what was awarded, and promise when it will be done (plant clock)."""
    accepted = Accepted(
        task=award.task, epoch=award.epoch, role=award.role, finish_s=finish_s, number=award.number
    )
    return Send(coordinator, accepted)


def decline(coordinator: str, award: Award, reason: Refusal) -> Effect:
    """Take it not: much may have changed since the bid."""
    declined = Declined(
        task=award.task, epoch=award.epoch, role=award.role, reason=reason, number=award.number
    )
    return Send(coordinator, declined)
