"""Another plant, load or duration for a scenario."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

from dray.plant import Plant, default_plant
from dray_sim.run.stage import Shift

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Site:
    """Deviations from the scenario; None for its own value.

    Attributes:
        plant: instead of the default one.
        load: part of the machines' time that the demand takes, above 0.
        hours: of demand, above 0.
        traffic: whether vehicles take up room, and drive with right of way; every scenario can be played without,
            too.
        strategists: number of strategists, also in every scenario; None for one, or the scenario's own number.
    """

    plant: Plant | None = None
    load: float | None = None
    hours: float | None = None
    traffic: bool = True
    strategists: int | None = None

    @property
    def is_other(self) -> bool:
        """Whether plant, load or time are other than in the scenario."""
        return replace(self, traffic=True, strategists=None) != Site()

    @property
    def ground(self) -> Plant:
        """The plant that is played in."""
        return self.plant or default_plant()

    def shift(self, shift: Shift) -> Shift:
        """The shift as it is played here."""
        if self.load is not None:
            shift = replace(shift, load=self.load)
        if self.hours is not None:
            shift = replace(shift, duration_s=self.hours * 3600.0)
        return shift

    def __str__(self) -> str:
        """A text for a reader."""
        parts = []
        if self.plant is not None:
            parts.append(f"the plant {self.plant.id} ({self.plant.name})")
        if self.load is not None:
            parts.append(f"a load of {self.load:.0%}")
        if self.hours is not None:
            parts.append(f"{self.hours:g} hours")
        if self.strategists is not None:
            parts.append(f"{self.strategists} strategists" if self.strategists > 1 else "one strategist")
        if not self.traffic:
            parts.append("vehicles that pass through one another")
        return ", ".join(parts)
