"""Parts that lie at a machine and that nobody here needs: a storage is asked to have them fetched.

Made parts wait at their machine for whoever needs them. They go to a storage when nothing more of them is made here, or little room is left
for another piece; so does what lies in a buffer and no goal of this machine takes any more. The storage's station coordinates that
transport as any other that somebody has asked for (`transports.called`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from dray.memory import PutAwayMemory
from dray.messages import (
    TRANSPORT_ENDED,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportState,
)
from dray.plant import Plant
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.running import life_mark

PUT_AWAY = "put away"

AGAIN_S = 30.0
"""A station is asked so often how far it is; it tells nothing by itself."""

GIVEN_UP_S = 300.0
"""A storage that has not fetched anything by then has no room, or others have fetched it: another one is asked, if there is still need.
Whoever has nothing to do hears of nothing else that makes it look, so it looks `AGAIN_S` later."""


class PutAway:
    """For one machine: at most one transport of each part at a time.

    Args:
        machine: whose parts.
        plant: the storages, and their sizes of containers.
        life: its agent's; its alarms are named ``(PUT_AWAY, transport)``.
        look: called with now_s a while after a storage has fetched something, or has not: there may be more of it.
        incarnation: how often the machine was started.

    Attributes:
        alarms: what to call when an alarm of this class has come, with (transport, now_s).
    """

    def __init__(
        self, machine: str, plant: Plant, life: Life, look: Callable[[float], None], *, incarnation: int
    ) -> None:
        self._machine, self._plant = machine, plant
        self._look = look
        self._life, self._mark = life, life_mark(incarnation)
        self._asked: dict[str, PutAwayMemory] = {}
        """By part."""
        self._since_s: dict[str, float] = {}
        """By transport, when it was asked for, or this life began."""
        self._state: dict[str, TransportState] = {}
        self._turn: dict[str, int] = {}
        """By part, which of its storages is asked next, the closest first."""
        self.count = 0
        self.alarms: dict[str, Callable[[Any, float], None]] = {PUT_AWAY: self._again}

    def restore(self, asked: Sequence[PutAwayMemory], count: int, now_s: float) -> None:
        """Go on with what an earlier life has asked for."""
        self.count = count
        for each in asked:
            self._asked[each.part] = each
            self._begin(each, now_s)

    def memories(self) -> tuple[PutAwayMemory, ...]:
        """For the next life."""
        return tuple(self._asked.values())

    def offer(self, part: str, pieces: int, now_s: float) -> None:
        """So many pieces of a part lie here that nobody needs and nobody has asked for."""
        storages = self._plant.storages_of(part)
        if part in self._asked or pieces <= 0 or not storages:
            return
        near = self._plant.closest(self._plant.node_of(self._machine), storages, len(storages))
        turn = self._turn.get(part, 0)
        self.count += 1
        asked = self._asked[part] = PutAwayMemory(
            transport=f"{self._machine}{self._mark}-away-{self.count}",
            storage=near[turn % len(near)],
            part=part,
            quantity=min(pieces, self._plant.materials[part].lot),
            due_s=now_s + GIVEN_UP_S,
        )
        self._life.commit()
        self._begin(asked, now_s)

    def on_answered(self, sender: str, answer: TransportAnswered, now_s: float) -> None:
        """A station tells how far it is."""
        asked = next((each for each in self._asked.values() if each.transport == answer.transport), None)
        if asked is None or asked.storage != sender:
            self._life.ignore("an answer about a transport that was not asked for")
            return
        self._state[asked.transport] = answer.state
        if answer.state in TRANSPORT_ENDED:
            del self._asked[asked.part], self._since_s[asked.transport], self._state[asked.transport]
            if answer.state is TransportState.CANCELLED:
                self._turn[asked.part] = self._turn.get(asked.part, 0) + 1
            # More of it may lie there, or still the same.
            self._life.alarm((PUT_AWAY, asked.transport), now_s + AGAIN_S)
            self._life.commit()

    def _begin(self, asked: PutAwayMemory, now_s: float) -> None:
        self._since_s[asked.transport] = now_s
        self._state[asked.transport] = TransportState.WAITING
        self._say(asked, now_s)

    def _again(self, transport: str, now_s: float) -> None:
        asked = next((each for each in self._asked.values() if each.transport == transport), None)
        if asked is not None:
            self._say(asked, now_s)
        else:
            self._look(now_s)

    def _say(self, asked: PutAwayMemory, now_s: float) -> None:
        waits = self._state[asked.transport] is TransportState.WAITING
        if waits and now_s >= self._since_s[asked.transport] + GIVEN_UP_S:
            self._life.send(asked.storage, TransportCancelled(asked.transport))
        else:
            order = TransportOrdered(asked.transport, self._machine, asked.part, asked.quantity, asked.due_s)
            self._life.send(asked.storage, order)
        self._life.alarm((PUT_AWAY, asked.transport), now_s + AGAIN_S)
