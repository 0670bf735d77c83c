"""The transports of one coordinator for which no vehicle was found yet, the most urgent first (docs/protocol.md, overload).

Urgent is what was needed first, or has waited long (`auction_rules.PATIENCE_S`). Of what needs the same vehicles only the most
urgent is announced; a vehicle that asks for work is offered that one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import cast

from dray.messages import Transport
from dray.protocol.contract_net.task import OpenTask


def stands_back(task: OpenTask, others: Iterable[OpenTask]) -> bool:
    """Whether the same vehicles were sought in vain for something more urgent, which waits for them."""
    wanted, urgency = _wanted(task), _urgency(task)
    return any(
        other.auction.was_in_vain and _wanted(other) == wanted and _urgency(other) < urgency
        for other in others
    )


def most_urgent(tasks: Iterable[OpenTask], atv: str, abilities: Collection[str]) -> OpenTask | None:
    """What a vehicle with these abilities should be offered first; None where nothing waits for it."""
    waiting = [
        task
        for task in tasks
        if task.auction.waits
        and _wanted(task)[1] in ("", atv)
        and all(ability in abilities for ability in _wanted(task)[0])
    ]
    return min(waiting, key=_urgency, default=None)


def _wanted(task: OpenTask) -> tuple[tuple[str, ...], str]:
    """The abilities that a vehicle needs for it, and the only one that may carry it; empty for any."""
    work = cast(Transport, task.work)
    return work.needed, work.vehicle


def _urgency(task: OpenTask) -> tuple[float, str]:
    return task.auction.needed_s, task.id
