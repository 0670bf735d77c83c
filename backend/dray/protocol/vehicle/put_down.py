"""Loads that the vehicle has put down and that their coordinator has not confirmed: it goes on telling of them.

A coordinator that is started again after the vehicle has gone on (`Reason.NOT_CONFIRMED`) knows of the load only from
this report, if its body does not count. It must hear it before it seeks another carrier (`failover.UNNAMED_S`). The same
holds for a load that came down although the contract was void, or that was released before its report was answered.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dray.memory import Contract
from dray.messages import Handover, HandoverAccepted, Superseded, Withdrawn
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.retransmission import Retransmitter

TELL = "tell of a load that is down"
"""Alarm of a repeated report, by task."""

TELLS = 300
"""Maximum reports of one load: a quarter of an hour."""

LOADS_KEPT = 8
"""Maximum loads that it tells of: the oldest is dropped."""


class PutDown:
    """The unconfirmed loads of one vehicle.

    Args:
        life: the agent's life; alarms are named ``(TELL, task)``.

    Attributes:
        alarms: handlers of these alarms.
    """

    def __init__(self, life: Life) -> None:
        self._life = life
        self._loads: dict[str, Contract] = {}
        """By task: its ended contract, the oldest first."""
        self._told = Retransmitter(TELL, life, most=TELLS)
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {TELL: self._tell_again}

    def add(self, contract: Contract, now_s: float) -> None:
        """The coordinator has not answered while the vehicle stood there."""
        self._loads[contract.task] = contract
        handover = Handover(task=contract.task, epoch=contract.epoch, quantity=contract.work.quantity)
        self._told.say(contract.task, Send(contract.coordinator, handover), now_s)
        if len(self._loads) > LOADS_KEPT:
            self.forget(next(iter(self._loads)))

    def forget(self, task: str) -> None:
        """Tell of a load no more. Ignored if it is unknown."""
        if self._loads.pop(task, None) is not None:
            self._told.settle(task)

    def on_answer(self, message: HandoverAccepted | Superseded | Withdrawn) -> bool:
        """Handle a coordinator's answer; returns whether it was about such a load."""
        load = self._loads.get(message.task)
        if load is None or not (isinstance(message, Superseded) or message.epoch == load.epoch):
            return False
        self.forget(message.task)
        return True

    def memories(self) -> tuple[Contract, ...]:
        """The ended contracts, for the next life."""
        return tuple(self._loads.values())

    def coordinator_of(self, task: str) -> str:
        """The coordinator that is told of a load; empty without one."""
        return self._loads[task].coordinator if task in self._loads else ""

    def _tell_again(self, task: str, now_s: float) -> None:
        if self._told.is_exhausted(task):
            self.forget(task)
        else:
            self._told.wake(task, now_s)
