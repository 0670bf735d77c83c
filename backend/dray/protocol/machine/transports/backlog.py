"""The transports of one machine for which no vehicle was found yet, the most urgent first (docs/protocol.md, overload).

Urgent is what was needed first, or has waited long (`auction.PATIENCE_S`). Of what needs the same vehicles only the most
urgent is announced; a vehicle that asks for work is offered that one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import cast

from dray.messages import Phase, Transport
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.machine.supply import Supply


def stands_back(task: OpenTask, others: Iterable[OpenTask]) -> bool:
    """Whether the same vehicles were sought in vain for something more urgent, which waits for them."""
    ability, urgency = _ability(task), _urgency(task)
    return any(
        other.auction.was_in_vain and _ability(other) == ability and _urgency(other) < urgency
        for other in others
    )


def most_urgent(tasks: Iterable[OpenTask], abilities: Collection[str]) -> OpenTask | None:
    """What a vehicle with these abilities should be offered first; None where nothing waits for it."""
    waiting = [task for task in tasks if task.auction.waits and _ability(task) in abilities]
    return min(waiting, key=_urgency, default=None)


def unneeded(tasks: Iterable[OpenTask], supply: Supply) -> list[OpenTask]:
    """Transports of material that no goal takes any more, and that nobody has on board, as far as is known."""
    return [
        task
        for task in tasks
        if not task.is_of_goods
        and task.contract.phase in (None, Phase.APPROACHING)
        and cast(Transport, task.work).item in supply.materials
        and not supply.needs(task.work_item, "")
    ]


def _ability(task: OpenTask) -> str:
    return cast(Transport, task.work).ability


def _urgency(task: OpenTask) -> tuple[float, str]:
    return task.auction.needed_s, task.id
