"""A vehicle that was started without right of way, where others drive with it: it stands, and says so."""

from __future__ import annotations

from collections.abc import Callable

from dray.body import Hold, ProblemRaised
from dray.messages import FloorTold, HoldsAsked, Message, YieldAsked
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.events import Effect, Instruct, Subscribe

PROBLEM = "started without right of way, and others drive with it; set DRAY_TRAFFIC alike for all"

BELIEVED_BY = 2
"""Keepers of books who say so: one alone may lie."""


class AloneAmongOthers:
    """Notices that others drive with right of way: those who keep the books ask it what it holds, or tell of their districts.

    Args:
        plant: whose machines and storages may keep books.
        out: where effects go.
        raise_problem: tells that the vehicle stands until a person has seen to it.
    """

    def __init__(
        self, plant: Plant, out: list[Effect], raise_problem: Callable[[ProblemRaised, float], None]
    ) -> None:
        self._plant = plant
        self._out = out
        self._raise_problem = raise_problem
        self._asked_by: set[str] = set()

    def fill(self, messages: dict[type[Message], Callable[..., None]]) -> None:
        """Enter what there is to see to into the vehicle's table, and listen to whoever keeps a book: where none is kept, nobody speaks."""
        messages[HoldsAsked] = messages[YieldAsked] = messages[FloorTold] = self._on_asked
        self._out.append(Subscribe(Keys(self._plant.id).all_floors))

    def _on_asked(self, sender: str, _message: Message, now_s: float) -> None:
        if sender not in self._plant.machines and sender not in self._plant.stores:
            return
        first = len(self._asked_by) < BELIEVED_BY
        self._asked_by.add(sender)
        if len(self._asked_by) >= BELIEVED_BY:
            self._out.append(Instruct(Hold()))
            if first:
                self._raise_problem(ProblemRaised(reason=PROBLEM), now_s)
