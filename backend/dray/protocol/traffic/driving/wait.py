"""A vehicle's wait for its next places: since when, for which vehicle, and what follows from its length.

`right_of_way.py` says when a wait begins and ends, and what the tables answer meanwhile.
"""

from __future__ import annotations

from dataclasses import dataclass

from dray.messages.floor.traffic import Blocked, PlaceGranted
from dray.plant.restrictions import Ends
from dray.protocol.runtime.life import Change

AGES_EVERY_S, AGES_BY_S = 30.0, 240.0
"""Every 30 s of a wait add 240 s to the age of a vehicle's leg. Otherwise a vehicle where many pass waits for all that began their
legs before it."""

SHUT_OUT_S = 30.0
"""Wait for a silent vehicle after which the way past it counts as closed; most that were switched off briefly are back by then."""


@dataclass(frozen=True, slots=True)
class ShutOut(Change):
    """A vehicle is shut out: a silent vehicle holds a place that it needs, and no way leads round it."""

    by: str
    """The silent vehicle."""
    lanes: tuple[Ends, ...]
    """Lanes into the place that it holds, beginning with the one on the way of the shut-out vehicle."""
    waited_s: float
    """How long the shut-out vehicle has waited."""


class Wait:
    """One vehicle's wait, and how long it has waited on its present leg.

    Attributes:
        since_s: since when it stands and waits; None while it does not.
        at_goal_s: time on this leg for which it stood only because its goal, such as a dock, was held.
    """

    def __init__(self) -> None:
        self.since_s: float | None = None
        self.at_goal_s = 0.0
        self._blocked, self._by, self._at = Blocked.NO, "", ""
        """Why its next places were not granted, the vehicle in the way, and the place, by the table's newest answer."""
        self._silent_since_s = 0.0
        """Since when a silent vehicle is in the way, if one is."""
        self._aged_s = 0.0
        """When a wait last made the vehicle more urgent."""

    @property
    def is_on(self) -> bool:
        """Whether it waits."""
        return self.since_s is not None

    @property
    def by(self) -> str:
        """The vehicle that holds its next place, or goes first; empty when it waits for none, or does not know."""
        return self._by if self.is_on else ""

    @property
    def at(self) -> str:
        """The place for which it waits; empty when it waits for none, or does not know."""
        return self._at if self.is_on else ""

    @property
    def is_for_silent(self) -> bool:
        """Whether it waits for a silent vehicle."""
        return self.is_on and self._blocked is Blocked.SILENT

    def for_silent_s(self, now_s: float) -> float:
        """How long it has waited for the same silent vehicle; 0 when it waits for none."""
        if self.since_s is None or not self.is_for_silent:
            return 0.0
        return now_s - max(self.since_s, self._silent_since_s)

    def begin_leg(self) -> None:
        """Forget the waits of the leg before."""
        self.since_s, self.at_goal_s = None, 0.0

    def begin_wait(self, now_s: float) -> None:
        """The vehicle stands and wants places."""
        self.since_s = now_s

    def end_wait(self, now_s: float, *, at_goal: bool = False) -> float:
        """The vehicle drives on, or wants nothing more. Returns how long it has waited (s)."""
        waited_s = 0.0 if self.since_s is None else now_s - self.since_s
        self.since_s = None
        if at_goal:
            self.at_goal_s += waited_s
        return waited_s

    def note(self, granted: PlaceGranted, now_s: float) -> None:
        """Note why a table does not grant the next places; it may tell before the vehicle stands."""
        if self._blocked is not Blocked.SILENT or self._by != granted.by:
            self._silent_since_s = now_s
        self._blocked, self._by, self._at = granted.blocked, granted.by, granted.at

    def ages(self, now_s: float) -> bool:
        """Whether it makes the vehicle more urgent now: once in `AGES_EVERY_S`, and not behind a docked or silent vehicle."""
        if self.since_s is None or self._blocked is not Blocked.WAIT:
            return False
        if now_s - max(self.since_s, self._aged_s) < AGES_EVERY_S:
            return False
        self._aged_s = now_s
        return True
