"""A person who looks for the loads of held transports.

A place whose body counts has counted all that is put down there: the person finds nothing, and says so
(`LOAD_MISSING`). At others the person finds what the body does not know of (`LOAD_THERE`). Where carriers fail the person
finds the dock in order, and says so (`LOAD_MISSING`). The looker takes part in a
run only when a transport is held: a run without one is the same with and without a looker.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from dray.adapters.security.signing import SigningKey
from dray.messages import (
    CommandAnswered,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Message,
    Reason,
    StationHeartbeat,
    TaskBrief,
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


class LoadLooker:
    """Implements `dray_sim.network.listeners.Listener`.

    Args:
        bus: joined when the first transport is held.
        clock: the plant's clock.
        authority: grants the reports.
        uncounted: by place and item, the pieces that lie there unknown to its body; None while that cannot be told.

    Attributes:
        looked: transports that it has looked for, the oldest first.
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
        self._held: dict[str, tuple[str, TaskBrief]] = {}
        """Transports to look for, by id, with the coordinator of each."""
        self._news = asyncio.Event()
        self.looked: list[str] = []

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        """See `dray_sim.network.listeners.Listener`."""
        if not isinstance(message, MachineHeartbeat | StationHeartbeat):
            return
        for brief in message.tasks:
            if brief.trouble is Reason.DISPUTED:
                place = message.machine if isinstance(message, MachineHeartbeat) else message.station
                self._held[brief.task] = place, brief
                self._news.set()

    async def run(self) -> None:
        """Look for one load after the other, until cancelled."""
        while True:
            await self._news.wait()
            self._news.clear()
            await asyncio.sleep(WALK_S)
            held, self._held = self._held, {}
            for place, brief in held.values():
                there = self._look(place, brief)
                if there is not None:
                    await self._say(place, brief.task, there=there)
                    self.looked.append(brief.task)

    def _look(self, place: str, brief: TaskBrief) -> bool | None:
        """Whether a load lies there; None while that cannot be told: the next heartbeat asks again."""
        if brief.fails_at or brief.destination != place:
            return False
        pieces = self._uncounted(place, brief.item)
        # A cycle that has begun may have used a few pieces that are still counted.
        return None if pieces is None else 2 * pieces > brief.quantity

    async def _say(self, place: str, task: str, *, there: bool) -> None:
        if self._session is None:
            self._session = self._bus.join(NAME, self._on_message)
        name = f"{NAME}-{len(self.looked) + 1}"
        kind = MachineCommandKind.LOAD_THERE if there else MachineCommandKind.LOAD_MISSING
        word = MachineCommand(command=name, kind=kind, task=task, issued_by=NAME)
        with self._answers.to(name) as answer:
            while not answer.done():
                until_s = self._clock.now_s() + GRANT_S
                granted = self._authority.grant(place, word, person=NAME, areas=None, valid_until_s=until_s)
                self._session.send(place, granted)
                await asyncio.wait((answer,), timeout=AGAIN_S)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered):
            self._answers.take(message)
