"""Vehicles at one dock: those that wait for it to open, and those that were let in."""

from __future__ import annotations

from typing import NamedTuple

from dray.memory import DepartureMemory
from dray.messages import Docked


class Entry(NamedTuple):
    """The transfer that a vehicle has asked the dock for, or is let in for."""

    task: str
    epoch: int
    item: str
    comes: bool
    """True if it unloads, false if it loads."""

    def is_of(self, load: DepartureMemory) -> bool:
        """Whether the vehicle is let in for this load."""
        return (self.task, self.epoch) == (load.task, load.epoch)


OF_EARLIER_LIFE = Entry("", 0, "", comes=False)
"""The entry of a vehicle that an earlier life let in: its purpose is unknown."""


class Visits:
    """The visits of vehicles at one dock, which its door, its departures and its bookings share.

    Attributes:
        answers: whether the body reports when it has opened (`dray.body.WorkcellState`); otherwise it is open at
            once.
        counts: whether the body counts what vehicles bring and take.
        asked: by vehicle, its request that waits for the dock to open.
        since_s: by vehicle, since when it is the next one (plant clock, s).
        asked_s: by vehicle, when it last asked (plant clock, s).
        inside: vehicles that were let in and may be inside.
    """

    def __init__(self) -> None:
        self.answers = False
        self.counts = True
        self.asked: dict[str, tuple[Docked, Entry]] = {}
        self.since_s: dict[str, float] = {}
        self.asked_s: dict[str, float] = {}
        self.inside: dict[str, Entry] = {}

    def forget_request(self, vehicle: str) -> tuple[Docked, Entry] | None:
        """Forget a request. Returns it; None if the vehicle has not asked."""
        self.since_s.pop(vehicle, None)
        self.asked_s.pop(vehicle, None)
        return self.asked.pop(vehicle, None)

    def note_departed(self, vehicle: str, task: str) -> None:
        """A vehicle has left; forget its request for that task (empty if the task is unknown).

        Its later requests stay.
        """
        self.inside.pop(vehicle, None)
        if vehicle in self.asked and self.asked[vehicle][1].task == task:
            self.forget_request(vehicle)

    def is_here(self, vehicle: str) -> bool:
        """Whether a vehicle was let in, or waits for that."""
        return vehicle in self.inside or vehicle in self.asked

    def is_of_earlier_life(self, vehicle: str) -> bool:
        """Whether an earlier life let a vehicle in."""
        return self.inside.get(vehicle) == OF_EARLIER_LIFE

    def is_report_awaited(self, vehicle: str) -> bool:
        """Whether a body that opens at once and does not count waits for a report on a vehicle that is not inside."""
        return not self.answers and not self.counts and vehicle not in self.inside
