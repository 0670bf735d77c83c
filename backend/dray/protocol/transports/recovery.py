"""After a restart a coordinator listens for unknown vehicles that work for it.

Its notes tell what it had announced, and nearly always the carrier. An award that was accepted while it was down is
noted only by the vehicle. The same holds for everything if the notes are lost.
"""

from __future__ import annotations

from collections.abc import Collection

from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Brief, Phase, Transport
from dray.messages.base import COUNT_MAX
from dray.plant import Plant
from dray.protocol.liveness.failure_detector import EVERYBODY, HeartbeatSubscriptions
from dray.protocol.runtime.life import Life
from dray.protocol.transports.transports import RECOVERY_WAIT_S, Stock, Transports

RECOVERY_WAIT = "recovery wait"

ON_THE_WAY = frozenset({Phase.APPROACHING, Phase.LOADING, Phase.CARRYING, Phase.UNLOADING})
"""Phases of a transport before its handover: only these are taken up by a coordinator without notes."""

EPOCH_MAX = COUNT_MAX // 2
"""Highest believed epoch of a contract that only the vehicle knows: later epochs still have numbers."""


class Recovery:
    """The first seconds of a coordinator's later lives.

    Args:
        place: the restarted coordinator.
        plant: the plant, for the sources of materials.
        subscriptions: its heartbeat subscriptions.
        tasks: its transports.
        stock: its stock.
        items: the items that are brought to it.
        life: the agent's life; alarms are named `RECOVERY_WAIT`.
    """

    def __init__(
        self,
        place: str,
        plant: Plant,
        subscriptions: HeartbeatSubscriptions,
        tasks: Transports,
        stock: Stock,
        life: Life,
        *,
        items: Collection[str],
    ) -> None:
        self._place = place
        self._plant = plant
        self._subscriptions = subscriptions
        self._tasks, self._stock = tasks, stock
        self._items = items
        self._life = life
        self._forgetful = False
        """Whether notes of the life before are missing."""

    def listen(self, forgetful: bool, now_s: float) -> None:
        """Listen to all vehicles for a while."""
        self._forgetful = forgetful
        self._subscriptions.follow(EVERYBODY)
        self._life.alarm(RECOVERY_WAIT, now_s + RECOVERY_WAIT_S)

    def stop_listening(self) -> None:
        """Stop listening to all vehicles, after the alarm."""
        self._subscriptions.unfollow(EVERYBODY)

    @property
    def is_listening_for_all(self) -> bool:
        """Whether notes are missing, and carriers may still report their tasks."""
        return self._forgetful and self._life.awaits(RECOVERY_WAIT)

    def waits_for_word_on(self, task: str) -> bool:
        """Whether an unknown task may be one of an earlier life, which its carrier's heartbeat may still name."""
        if not self.is_listening_for_all:
            return False
        return self._tasks.get(task) is None and self._tasks.closed(task) is None

    def on_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> Transport | None:
        """Handle a heartbeat, which may name this coordinator. Returns a work that is known only from it; else None."""
        brief = heartbeat.task
        if brief is None or brief.coordinator != self._place or not self._life.awaits(RECOVERY_WAIT):
            return None
        known = self._tasks.get(brief.task)
        if known is not None:
            self._tasks.acknowledge_carrier(heartbeat.atv, brief, now_s)
        elif (
            self.waits_for_word_on(brief.task)
            and self._is_ours(brief)
            and not self._carries_already(heartbeat.atv)
        ):
            plant, item = self._plant, brief.item
            storages = plant.storages_of(item)
            supplies = plant.supplies_of(item) if self._place in plant.storages else ()
            work = Transport(
                item=brief.item,
                quantity=brief.quantity,
                sources=supplies or tuple(each for each in storages if each != self._place) or storages,
                destination=self._place,
                ability=self._plant.materials[brief.item].ability,
            )
            self._tasks.acknowledge_unknown(heartbeat.atv, brief, work, now_s)
            return work
        return None

    def moved(self, heartbeat: AtvHeartbeat) -> DepartureMemory | None:
        """The load that a vehicle has moved here for a task without notes, by its own word; None for none.

        It hands it over still, or has not driven away with it yet. A vehicle that carries its own coordinator's
        material comes; whatever else it carries here is from here. The dock opens for no more than finds room.
        """
        brief, pieces = heartbeat.task, heartbeat.load_quantity
        if brief is None or self._tasks.get(brief.task) or self._tasks.closed(brief.task):
            return None
        comes = brief.coordinator == self._place and brief.item in self._items
        is_there = heartbeat.load == brief.item and 0 < pieces <= self._stock.level(brief.item)
        if brief.phase is Phase.HANDING_OVER and comes and self.is_listening_for_all:
            change = min(brief.quantity, max(self._stock.room(brief.item), 0))
        elif brief.phase is Phase.CARRYING and is_there and not comes:
            change = -pieces
        else:
            return None
        return DepartureMemory(heartbeat.atv, brief.task, brief.epoch, brief.item, change)

    def _carries_already(self, atv: str) -> bool:
        """Whether a vehicle has a contract already: one vehicle has at most one."""
        return any(task.primary == atv for task in self._tasks)

    def _is_ours(self, brief: Brief) -> bool:
        is_ours = brief.item in self._items and brief.phase in ON_THE_WAY and brief.epoch <= EPOCH_MAX
        return is_ours and brief.quantity <= self._stock.level(brief.item) + self._stock.room(brief.item)
