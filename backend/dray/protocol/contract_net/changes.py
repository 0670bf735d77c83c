"""Changes of a coordinator's tasks, to which its agent reacts."""

from __future__ import annotations

from dataclasses import dataclass

from dray.protocol.contract_net.task import OpenTask
from dray.protocol.runtime.life import Change


@dataclass(frozen=True, slots=True)
class ContractChanged(Change):
    """An open task has a contractor, another one, or none for now; or it waits for its contractor."""

    task: OpenTask


@dataclass(frozen=True, slots=True)
class TaskLost(Change):
    """A task was withdrawn, although what it was for may still be needed."""

    task: OpenTask


@dataclass(frozen=True, slots=True)
class TaskDelivered(Change):
    """A task was delivered.

    Attributes:
        carrier: the vehicle that has reported it; empty if none has.
        counted: pieces that have come.
    """

    task: OpenTask
    carrier: str
    counted: int
