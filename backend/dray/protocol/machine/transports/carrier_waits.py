"""How long carriers of one machine have waited where they load and unload: seen in their phases, told to the next ones."""

from __future__ import annotations

from collections.abc import Iterable
from typing import cast

from dray.messages import AtvHeartbeat, Phase, Transport, Wait
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.waits import Waits
from dray.protocol.runtime.events import NEVER_S


class CarrierWaits:
    """What one machine has seen of its carriers' waits.

    Args:
        machine: whose carriers.
        handling_s: the longest loading or unloading; what is beyond that is a wait.
    """

    def __init__(self, machine: str, handling_s: float) -> None:
        self._machine = machine
        self._handling_s = handling_s
        self._waits = Waits()

    def note_phase(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """See how far a carrier has come, and how long it had to wait for that."""
        brief, contract = heartbeat.task, task.contract
        if brief is None or brief.task != task.id or brief.phase is contract.phase:
            return
        waited_s = now_s - contract.phase_s - self._handling_s
        if contract.phase is Phase.LOADING and brief.phase is Phase.CARRYING:
            self._waits.note(contract.source, task.primary, waited_s, now_s)
        elif contract.phase is Phase.UNLOADING and brief.phase is Phase.HANDING_OVER:
            self._waits.note(cast(Transport, task.work).destination, task.primary, waited_s, now_s)
        contract.phase, contract.phase_s = brief.phase, now_s

    def told(self, work: Transport, tasks: Iterable[OpenTask], now_s: float) -> tuple[Wait, ...]:
        """What is known of waits at the places of a transport: lately, and of who stands there now."""
        for task in tasks:
            if task.contract.held_s < NEVER_S:
                self._waits.note(self._machine, task.primary, now_s - task.contract.held_s, now_s)
        return self._waits.told((*work.sources, work.destination), now_s)
