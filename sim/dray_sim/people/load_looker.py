"""A person who looks for the loads of held transports, and for doubtful loads.

A place whose body counts has counted all that is put down there: the person finds nothing, and says so
(`LOAD_MISSING`). At others the person finds what the body does not know of (`LOAD_THERE`). Where carriers fail the person
finds the dock in order, and says so (`LOAD_MISSING`). The looker takes part in a run only when it is asked: a run without a
question is the same with and without a looker.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from math import inf
from typing import NamedTuple

from dray.adapters.security.signing import SigningKey
from dray.messages import (
    CommandAnswered,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Message,
    Reason,
    StationHeartbeat,
)
from dray.ports import Bus, Clock, Session
from dray_sim.people.answers import Answers

NAME = "load-looker"
"""Its name on the bus, and the person in whose name it reports."""

WALK_S = 60.0
"""Time from the news to the place."""

AGAIN_S = 5.0
"""Interval between two repetitions of an unanswered report."""

GRANT_S = 60.0
"""Validity of a report."""

COUNT_LASTS_S = 30.0
"""Time for which a count is repeated: later than that it tells of another moment."""


class _Sought(NamedTuple):
    """A load to look for."""

    name: str
    place: str
    """The agent that asks."""
    item: str
    quantity: int
    is_here: bool = True
    """Whether it may lie at that place; not where carriers fail."""
    is_doubtful: bool = False


class LoadLooker:
    """Implements `dray_sim.network.listeners.Listener`.

    Args:
        bus: joined when the first transport is held.
        clock: the plant's clock.
        authority: grants the reports.
        uncounted: by place and item, the pieces that lie there unknown to its body; None while that cannot be told.

    Attributes:
        looked: transports and doubtful loads that it has looked for, the oldest first.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        authority: SigningKey,
        uncounted: Callable[[str, str], int | None],
    ) -> None:
        self._bus, self._clock, self._authority = bus, clock, authority
        self._uncounted = uncounted
        self._session: Session | None = None
        self._answers = Answers()
        self._sought: dict[str, _Sought] = {}
        """Loads to look for, by name."""
        self._doubted: dict[str, bool] = {}
        """By place: whether its last heartbeat asked for a doubtful load."""
        self._news = asyncio.Event()
        self.looked: list[str] = []

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        """See `dray_sim.network.listeners.Listener`."""
        if not isinstance(message, MachineHeartbeat | StationHeartbeat):
            return
        place = message.machine if isinstance(message, MachineHeartbeat) else message.station
        self._doubted[place] = bool(message.doubts)
        for brief in message.tasks:
            if brief.trouble is Reason.DISPUTED:
                here = brief.destination == place and not brief.fails_at
                self._seek(_Sought(brief.task, place, brief.item, brief.quantity, is_here=here))
        for doubt in message.doubts:
            self._seek(_Sought(doubt.load, place, doubt.item, doubt.quantity, is_doubtful=True))

    def _seek(self, sought: _Sought) -> None:
        self._sought[sought.name] = sought
        self._news.set()

    @property
    def is_asked(self) -> bool:
        """Whether a place asks for a doubtful load."""
        return any(self._doubted.values())

    async def run(self) -> None:
        """Look for one load after the other, until cancelled."""
        while True:
            await self._news.wait()
            self._news.clear()
            await asyncio.sleep(WALK_S)
            sought, self._sought = self._sought, {}
            for each in sought.values():
                there = self._look(each)
                if there is not None:
                    await self._say(each, there=there)
                    self.looked.append(each.name)

    def _look(self, sought: _Sought) -> bool | None:
        """Whether a load lies there; None while that cannot be told: the next heartbeat asks again."""
        if not sought.is_here:
            return False
        pieces = self._uncounted(sought.place, sought.item)
        # A cycle that has begun may have used a few pieces that are still counted.
        return None if pieces is None else 2 * pieces > sought.quantity

    async def _say(self, sought: _Sought, *, there: bool) -> None:
        place = sought.place
        lasts_until_s = self._clock.now_s() + (COUNT_LASTS_S if sought.is_doubtful else inf)
        if self._session is None:
            self._session = self._bus.join(NAME, self._on_message)
        name = f"{NAME}-{len(self.looked) + 1}"
        kind = MachineCommandKind.LOAD_THERE if there else MachineCommandKind.LOAD_MISSING
        word = MachineCommand(command=name, kind=kind, task=sought.name, issued_by=NAME)
        with self._answers.to(name) as answer:
            while not answer.done() and self._clock.now_s() < lasts_until_s:
                until_s = self._clock.now_s() + GRANT_S
                granted = self._authority.grant(place, word, person=NAME, areas=None, valid_until_s=until_s)
                self._session.send(place, granted)
                await asyncio.wait((answer,), timeout=AGAIN_S)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered):
            self._answers.take(message)
