"""Parts that lie unneeded at a machine: a storage is asked to have them fetched.

Made parts wait at their machine until they are fetched. They go to a storage when no more of them is made here, or
when little room is left. Parts in a buffer that no goal of this machine takes go there too. The storage's station
coordinates that transport like any other order (`transports.called`).
"""

from __future__ import annotations

from collections.abc import Sequence

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

PUT_AWAY = "put away"

AGAIN_S = 30.0
"""Interval for asking a station (s), which reports nothing by itself."""

GIVEN_UP_S = 300.0
"""Time after which a storage without a fetch is given up (s): it has no room, or others have fetched the parts. Then
another one is asked if needed. An idle machine has no other occasion, so it checks again after `AGAIN_S`."""


class PutAway:
    """The put-away of one machine: at most one transport of each part at a time.

    Args:
        machine: the machine's id.
        plant: the storages, and their container sizes.
        life: the agent's life; alarms are named ``(PUT_AWAY, transport)``.

    Attributes:
        count: requests so far, over all lives.
    """

    def __init__(self, machine: str, plant: Plant, life: Life) -> None:
        self._machine, self._plant = machine, plant
        self._life, self._mark = life, life.mark
        self._asked: dict[str, PutAwayMemory] = {}
        """By part: the open request."""
        self._since_s: dict[str, float] = {}
        """By transport: when it was requested, or this life began."""
        self._state: dict[str, TransportState] = {}
        self._turn: dict[str, int] = {}
        """By part: index of the next storage to ask, the closest first."""
        self.count = 0

    def restore(self, asked: Sequence[PutAwayMemory], count: int, now_s: float) -> None:
        """Continue an earlier life's requests."""
        self.count = count
        for each in asked:
            self._asked[each.part] = each
            self._begin(each, now_s)

    def memories(self) -> tuple[PutAwayMemory, ...]:
        """The open requests, for the next life."""
        return tuple(self._asked.values())

    def offer(self, part: str, pieces: int, now_s: float) -> None:
        """Offer unneeded pieces of a part that are not requested."""
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
        """Handle a station's report."""
        asked = next((each for each in self._asked.values() if each.transport == answer.transport), None)
        if asked is None or asked.storage != sender:
            self._life.ignore("an answer about a transport that was not ordered there")
            return
        self._state[asked.transport] = answer.state
        if answer.state in TRANSPORT_ENDED:
            del self._asked[asked.part], self._since_s[asked.transport], self._state[asked.transport]
            if answer.state is TransportState.CANCELLED:
                self._turn[asked.part] = self._turn.get(asked.part, 0) + 1
            # There may be more of it, or the same pieces.
            self._life.alarm((PUT_AWAY, asked.transport), now_s + AGAIN_S)
            self._life.commit()

    def _begin(self, asked: PutAwayMemory, now_s: float) -> None:
        self._since_s[asked.transport] = now_s
        self._state[asked.transport] = TransportState.WAITING
        self._say(asked, now_s)

    def ask_again(self, transport: str, now_s: float) -> bool:
        """Repeat a request after its alarm. False if it has ended: there may be more parts."""
        asked = next((each for each in self._asked.values() if each.transport == transport), None)
        if asked is not None:
            self._say(asked, now_s)
        return asked is not None

    def _say(self, asked: PutAwayMemory, now_s: float) -> None:
        waits = self._state[asked.transport] is TransportState.WAITING
        if waits and now_s >= self._since_s[asked.transport] + GIVEN_UP_S:
            self._life.send(asked.storage, TransportCancelled(asked.transport))
        else:
            order = TransportOrdered(asked.transport, self._machine, asked.part, asked.quantity, asked.due_s)
            self._life.send(asked.storage, order)
        self._life.alarm((PUT_AWAY, asked.transport), now_s + AGAIN_S)
