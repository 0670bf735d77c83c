"""Loads of which nobody can tell whether they lie at this place (`visits`). They are not in the books.

    to take     it was booked out in doubt; its vehicle may not have taken it
    to bring    it was not booked in; its vehicle may have put it down

    waits --ASKS_AFTER_S--> asked --a person has found it--> booked in
      |                       |
      +-----------------------+--a person has not found it, has counted the item, or its vehicle has told--> over

A vehicle that remembers tells within seconds, so nobody is asked before. A body that counts leaves no doubt, and no
person is asked for what its controller measures (`dray.body.StorageState.measured`). A vehicle that leaves one load after
another in doubt may lie: people have to look before the dock opens for it again, to load or to bring something back.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice

from msgspec.structs import replace

from dray.memory import DepartureMemory, DoubtMemory
from dray.messages import THING, DoubtfulLoad
from dray.messages.fact import LoadDoubted
from dray.messages.heartbeat import DOUBTS_TOLD
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

ASKS_AFTER_S = 30.0
"""Time until a person is asked (s): a vehicle tells of a load every 3 s, and the link may be away for a moment."""

DOUBTS_KEPT = 64
"""Maximum doubts of one place; above that the oldest is forgotten."""

DOUBTS_OF_ONE = 4
"""Doubts about one vehicle's loads from which on it is let in no more by its own word. An honest one loses its journal here rarely."""


class Doubts:
    """The loads of one place of which nobody can tell.

    Attributes:
        measured: items whose level the controller measures: nobody is asked for them.
    """

    def __init__(self, life: Life) -> None:
        self._life = life
        self.measured: frozenset[str] = frozenset()
        self._doubts: BoundedMap[str, DoubtMemory] = BoundedMap(DOUBTS_KEPT)
        self._since_s: dict[str, float] = {}
        """By name: since when this life has waited for its vehicle (plant clock, s)."""
        self._count = 0
        """Doubts of this life so far, for their names."""

    def __iter__(self) -> Iterator[DoubtMemory]:
        """Those for which a person is asked, the oldest first."""
        return (doubt for doubt in self._doubts.values() if doubt.asked)

    @property
    def place(self) -> str:
        return self._life.agent

    def get(self, name: str) -> DepartureMemory | None:
        """The load for which a person is asked under this name; None for none."""
        doubt = self._doubts.get(name)
        return doubt.load if doubt is not None and doubt.asked else None

    def has_too_many(self, vehicle: str) -> bool:
        """Whether people have to look before a vehicle is let in again."""
        return sum(doubt.load.vehicle == vehicle for doubt in self._doubts.values()) >= DOUBTS_OF_ONE

    def note(self, load: DepartureMemory) -> None:
        """Nobody can tell of a load. Repeating this is harmless.

        Of one vehicle few are noted: who looks for those counts the rest.
        """
        if not load.change or load.item in ("", THING) or load.item in self.measured:
            return  # A person could count nothing, or need not.
        known = any(_is_same(doubt.load, load) for doubt in self._doubts.values())
        if known or self.has_too_many(load.vehicle):
            return
        self._count += 1
        name = f"{self.place}{self._life.mark}-load-{self._count}"
        self._doubts[name] = DoubtMemory(name, load)
        self._life.commit()

    def update(self, now_s: float) -> None:
        """Ask a person for each load that its vehicle has not told of in time."""
        self._since_s = {name: self._since_s.get(name, now_s) for name in self._doubts}
        for name, doubt in self._doubts.items():
            if doubt.asked or now_s < self._since_s[name] + ASKS_AFTER_S:
                continue
            self._doubts[name] = replace(doubt, asked=True)
            load = doubt.load
            fact = LoadDoubted(name, load.vehicle, load.item, load.quantity, load.brings, load.task)
            self._life.record(fact)
            self._life.commit()

    def told(self) -> tuple[DoubtfulLoad, ...]:
        """For the heartbeat, at most `DOUBTS_TOLD`."""
        return tuple(
            DoubtfulLoad(name, load.vehicle, load.item, load.quantity, load.brings)
            for name, load in ((doubt.name, doubt.load) for doubt in islice(self, DOUBTS_TOLD))
        )

    # --- the end of a doubt ---

    def settle(self, name: str) -> None:
        """A person has looked for a load."""
        if self._doubts.pop(name, None) is not None:
            self._life.commit()

    def on_told(self, load: DepartureMemory) -> None:
        """It is known what has become of a load."""
        for name in [name for name, doubt in self._doubts.items() if _is_same(doubt.load, load)]:
            self.settle(name)

    def on_counted(self, item: str, vehicle: str = "") -> None:
        """People have counted an item, or have said what one vehicle has moved of it."""
        for name, doubt in list(self._doubts.items()):
            if doubt.load.item == item and vehicle in ("", doubt.load.vehicle):
                self.settle(name)

    # --- over a restart ---

    def memories(self) -> tuple[DoubtMemory, ...]:
        """For the next life."""
        return tuple(self._doubts.values())

    def restore(self, memories: Iterable[DoubtMemory]) -> None:
        """Go on with the doubts of an earlier life."""
        for doubt in memories:
            self._doubts[doubt.name] = doubt


def _is_same(one: DepartureMemory, other: DepartureMemory) -> bool:
    """Whether two records are of one load, in one direction."""
    is_it = (one.vehicle, one.task, one.epoch) == (other.vehicle, other.task, other.epoch)
    return is_it and one.change * other.change > 0
