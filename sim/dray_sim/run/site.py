"""Where, how busy and for how long a scenario is played, when not as it stands."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

from dray.plant import Plant, default_plant
from dray_sim.run.stage import Shift

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Site:
    """What is other than in the scenario; None for what stays.

    Attributes:
        plant: instead of the default one.
        load: part of the machines' time that the demand takes, above 0.
        hours: of demand, above 0.
        traffic: vehicles take up room, and drive with right of way; every scenario can be played without, too.
        strategists: how many share the orders, also in every scenario; None: one, but where a scenario says otherwise.
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
        """For a reader."""
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
