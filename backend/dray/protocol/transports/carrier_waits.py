"""Waiting times of a coordinator's carriers at docks: measured from their phases, told to the next bidders."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import cast

from msgspec.structs import replace

from dray.messages import AtvHeartbeat, DockExpected, Phase, Transport, Wait
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.dock_queues import DockQueues
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.waits import Waits
from dray.protocol.runtime.events import NEVER_S, Subscribe

ONE_AFTER_ANOTHER_S = 1.2
"""Interval between announcements where carriers queue at docks (s): a bidding window, and the award."""

SETTLES_S = 10.0
"""Time after which a promise is settled (s): vehicles that others hired at the same moment have reported their arrival by
then. At 85 % load three in five missed promises had another vehicle hired for one of their docks within that time.
"""


def docks_heard(place: str, items: Iterable[str], plant: Plant, keys: Keys) -> tuple[Subscribe, ...]:
    """The dock topics that a coordinator subscribes to: the places where its transports begin and end."""
    storages = (storage for item in items for storage in plant.storages_of(item))
    places = dict.fromkeys(
        (place, *storages, *(plant.delivery_warehouses if place in plant.machines else ()))
    )
    return tuple(Subscribe(keys.dock(place)) for place in places)


class CarrierWaits:
    """One coordinator's measurements of its carriers' waits.

    Args:
        place: the coordinator's place.
        handling_s: the longest loading or unloading; more than that is a wait.
        tasks: the open tasks, by id.

    Attributes:
        docks: expected vehicles at docks, as vehicles with right of way report.
    """

    def __init__(self, place: str, handling_s: float, tasks: Mapping[str, OpenTask]) -> None:
        self._place = place
        self._tasks = tasks
        self._handling_s = handling_s
        self._waits = Waits()
        self.docks = DockQueues()

    def note_phase(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note a carrier's phase, and how long it waited before it."""
        brief, contract = heartbeat.task, task.contract
        if brief is None or brief.task != task.id or brief.phase is contract.phase:
            return
        waited_s = now_s - contract.phase_s - self._handling_s
        if contract.phase is Phase.LOADING and brief.phase is Phase.CARRYING:
            self._waits.note(contract.source, task.primary, waited_s, now_s)
        elif contract.phase is Phase.UNLOADING and brief.phase is Phase.HANDING_OVER:
            self._waits.note(cast(Transport, task.work).destination, task.primary, waited_s, now_s)
        contract.phase, contract.phase_s = brief.phase, now_s

    def on_expected(self, sender: str, said: DockExpected, now_s: float) -> None:
        """Handle a vehicle's arrival report: a carrier with a fresh promise may stand behind it."""
        self.docks.on_expected(sender, said, now_s)
        for task in self._tasks.values():
            contract = task.contract
            if contract.primary and now_s <= contract.bound_s + SETTLES_S:
                self.foresee(task, now_s)

    def foresee(self, task: OpenTask, now_s: float) -> None:
        """Settle the promise of a task's carrier: it may stand behind vehicles that it had not heard of.

        The part of its promise beyond its reported way is waiting time that it counted itself. It gets at most what
        it promised and the waits behind others.
        """
        contract, there = task.contract, cast(Transport, task.work).destination
        loads = self.docks.of(contract.source, contract.primary)
        unloads = self.docks.of(there, contract.primary)
        if loads is None or unloads is None or unloads.comes_s < contract.bound_s:
            return  # It has not reported its arrival yet.
        comes_s = max(loads.comes_s, contract.bound_s)
        waits_s = self.docks.wait_s(contract.source, comes_s, contract.primary, now_s)
        waits_s += self.docks.wait_s(there, unloads.comes_s + waits_s, contract.primary, now_s)
        counted_s = max(contract.first_promised_s - unloads.comes_s - unloads.stays_s, 0.0)
        contract.promised_s = contract.first_promised_s + waits_s - counted_s
        if contract.progress is not None:
            contract.progress.allow(contract.promised_s)

    def told(self, work: Transport, now_s: float) -> tuple[Wait, ...]:
        """Known waits at a transport's places: recent ones, the present one, and those behind expected vehicles."""
        for task in self._tasks.values():
            if task.contract.held_s < NEVER_S:
                self._waits.note(self._place, task.primary, now_s - task.contract.held_s, now_s)
        places = (*work.sources, work.destination)
        told = {wait.place: wait for wait in self._waits.told(places, now_s)}
        for place in places:
            if expected := self.docks.told(place, now_s):
                told[place] = replace(told.get(place, Wait(place=place, wait_s=0.0)), expected=expected)
        return tuple(told.values())
