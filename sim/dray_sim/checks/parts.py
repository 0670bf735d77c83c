"""Invariants 2 and 4 for parts: every piece is counted once, on every level.

`invariants.MaterialConserved` checks for all items that none appears or vanishes. These checks compare reports with
the truth. A machine reports no piece of a part that its workcell has not made, and a goal is closed with exactly its
pieces. The strategist's sum of all reports of a part may exceed the real number only briefly: for as long as a piece
takes from hand to hand.
"""

from __future__ import annotations

from collections import Counter

from dray.messages import (
    AtvHeartbeat,
    Event,
    MachineHeartbeat,
    Message,
    Production,
    StationHeartbeat,
)
from dray.messages.fact import PieceMade, TaskClosed, TaskOpened
from dray.protocol.strategist.part_stock import COUNTS_S, PartStock
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory


class PartsCountedOnce:
    """Checks one factory."""

    hears = (Event,)

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._work: dict[str, Production] = {}
        """Open goals of parts."""
        self._made: dict[str, int] = {}
        """Pieces of those goals that their machines have reported."""
        self._told: Counter[tuple[str, str]] = Counter()
        """Pieces that a machine has reported, by machine and part."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is TaskOpened:
            if type(fact.work) is Production and fact.work.part_of:
                self._work[fact.task] = fact.work
        elif type(fact) is PieceMade and fact.goal in self._work:
            self._count(fact, sender, at_s)
        elif type(fact) is TaskClosed and fact.task in self._work:
            work, made = self._work.pop(fact.task), self._made.pop(fact.task, 0)
            if fact.outcome == "delivered" and made != work.quantity:
                seen = f"{fact.task} was closed with {made} of {work.quantity} pieces of {work.product}"
                raise InvariantBroken(4, at_s, seen)

    def _count(self, fact: PieceMade, machine: str, at_s: float) -> None:
        self._told[machine, fact.product] += fact.made - self._made.get(fact.goal, 0)
        self._made[fact.goal] = fact.made
        told, made = self._told[machine, fact.product], self._factory.floor.workcells[machine].made
        if told > made[fact.product]:
            seen = f"{machine} tells of {told} pieces of {fact.product} and has made {made[fact.product]}"
            raise InvariantBroken(4, at_s, seen)


LOOK_S = 5.0
"""Interval between two counts."""

TWICE_S = 4.0 * COUNTS_S
"""Reports may be of different moments: a vehicle that falls silent as it puts a load down reports the load for a
minute longer. So a piece is counted twice now and then, but a different one each time. A sum that is wrong for this
long is an error."""


class ReportedOnce:
    """Only one agent reports each piece.

    Args:
        factory: its floor gives the true numbers.
        liar: an agent whose reports are ignored; empty when all are honest.
    """

    def __init__(self, factory: SimFactory, liar: str = "") -> None:
        self._floor, self._parts = factory.floor, factory.plant.parts
        self._liar = liar
        self._told = PartStock(factory.plant)
        self._look_s = 0.0
        self._right_s: dict[str, float] = {}
        """Last moment at which the reports did not exceed the real number, by part."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: more is told of a part than there is.
        """
        if not self._parts or sender == self._liar:
            return
        if type(message) is MachineHeartbeat:
            self._told.on_machine(message, at_s)
        elif type(message) is StationHeartbeat:
            self._told.on_station(sender, message, at_s)
        elif type(message) is AtvHeartbeat:
            self._told.on_vehicle(sender, message, at_s)
        if at_s >= self._look_s:
            self._look_s = at_s + LOOK_S
            self._look(at_s)

    def _look(self, at_s: float) -> None:
        lies = self._floor.lying()
        for part in self._parts:
            told = self._told.lies(part, at_s)
            if told <= lies[part]:
                self._right_s[part] = at_s
            elif at_s > self._right_s.setdefault(part, at_s) + TWICE_S:
                seen = f"{told} pieces of {part} are told of, and {lies[part]} are there"
                raise InvariantBroken(2, at_s, seen)
