"""Random transports from a seed: one after the other for each vehicle, or at random times for all (Poisson)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from dray.plant import Plant
from dray_sim.bench.traffic.clock import LeanClock

HANDLING_S = 15.0
"""Duration of loading, and of unloading (s)."""


@dataclass(frozen=True, slots=True)
class Job:
    """One transport.

    Attributes:
        source, goal: nodes of docks.
        since_s: time of its order.
    """

    source: str
    goal: str
    since_s: float


def docks_of(plant: Plant) -> tuple[str, ...]:
    """Nodes at which loads are taken up and put down: machines, storages and warehouses."""
    places = (*plant.machines, *plant.storages, *plant.warehouses)
    return tuple(dict.fromkeys(plant.node_of(place) for place in places))


class Saturated:
    """Each vehicle has its own sequence of transports, and starts the next one when one is done."""

    def __init__(self, plant: Plant, seed: int) -> None:
        self._docks = docks_of(plant)
        self._random = {atv: Random(f"jobs/{seed}/{atv}") for atv in plant.fleet}

    def next(self, atv: str, now_s: float) -> Job | None:
        source, goal = self._random[atv].sample(self._docks, 2)
        return Job(source, goal, now_s)

    def start(self, clock: LeanClock, wake: Callable[[], None]) -> None:
        """Do nothing: vehicles ask for transports."""


class Poisson:
    """Transports come at random times; a free vehicle takes the oldest.

    Args:
        per_h: mean number of transports in an hour.
    """

    def __init__(self, plant: Plant, seed: int, per_h: float) -> None:
        self._docks = docks_of(plant)
        self._random = Random(f"poisson/{seed}")
        self._per_s = per_h / 3600.0
        self._waiting: deque[Job] = deque()

    def next(self, atv: str, now_s: float) -> Job | None:
        return self._waiting.popleft() if self._waiting else None

    def start(self, clock: LeanClock, wake: Callable[[], None]) -> None:
        """Start the arrivals. `wake` is called after each, so that free vehicles ask."""

        def come() -> None:
            source, goal = self._random.sample(self._docks, 2)
            self._waiting.append(Job(source, goal, clock.now_s))
            wake()
            clock.call_at(clock.now_s + self._random.expovariate(self._per_s), come)

        clock.call_at(self._random.expovariate(self._per_s), come)
