"""The door of one dock: it opens for one vehicle and one load.

The dock's owner decides which vehicle may load or unload: a receiver asks its contracts (`transports.dock`), a
giver its reservations (`transports.issuing`).
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from dray.body import CloseDock, OpenDock, StockChanged
from dray.memory import DepartureMemory
from dray.messages import Docked, DockHeld, DockOpened
from dray.messages.heartbeat import DockWait
from dray.plant import Plant
from dray.protocol.runtime.life import Life
from dray.protocol.transports.booking_out import BookingOut
from dray.protocol.transports.departures import Departures
from dray.protocol.transports.visits import OF_EARLIER_LIFE, Entry, Visits

SAFE_WITHIN_S = 60.0
"""Time to make an idle dock safe (s): shut a door, run a conveyor empty."""


def ready_within_s(plant: Plant, place: str) -> float:
    """Time for a dock to get ready before a person should look (s); a running cycle may end first.

    Args:
        plant: the plant.
        place: the dock's place.
    """
    spec = plant.machines.get(place)
    return (
        SAFE_WITHIN_S + max((making.cycle_s for making in spec.makes), default=0.0) if spec else SAFE_WITHIN_S
    )


ASKS_STILL_S = 30.0
"""Time (s) after which a vehicle that asks no more has left: it repeats its request every 5 s while the dock is shut."""

NOT_READY = "the dock is not ready yet"
"""Reason for a vehicle to wait until the controller has made the dock safe."""


class Door:
    """The door of one dock.

    Args:
        visits: the vehicles at it.
        departures: vehicles that may still be at it after their transport ended there.
        booking_out: vehicles that were let in to load, if the body does not count.
        patience_s: how long the body may take to open it.
    """

    def __init__(
        self,
        visits: Visits,
        departures: Departures,
        booking_out: BookingOut,
        patience_s: float,
        life: Life,
    ) -> None:
        self.visits, self._departures, self._booking_out = visits, departures, booking_out
        self._patience_s, self._life = patience_s, life

    def open(
        self, vehicle: str, asked: Docked, item: str, quantity: int, now_s: float, *, comes: bool
    ) -> None:
        """Let a vehicle unload (`comes`) or load, once; it waits while the body makes the dock ready."""
        self._life.instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity))
        entry = Entry(asked.task, asked.epoch, item, comes)
        if self.visits.answers:
            self._forget_silent(now_s)
            self.visits.asked[vehicle] = asked, entry
            self.visits.asked_s[vehicle] = now_s
            self.visits.since_s.setdefault(vehicle, now_s)
            self.hold(vehicle, asked, NOT_READY)
        else:
            self._let_in(vehicle, entry)
            self.agree(vehicle, asked)

    def is_opening(self, vehicle: str) -> bool:
        """Whether a vehicle waits for the body to open the dock."""
        return vehicle in self.visits.asked

    def was_opened(self, vehicle: str) -> bool:
        """Whether the dock was opened for a vehicle that has not left since."""
        return vehicle in self.visits.inside

    def wait(self, now_s: float) -> DockWait | UnsetType:
        """The vehicle that has waited longest for the dock to open, if longer than `patience_s`."""
        vehicle = min(self.visits.since_s, key=self.visits.since_s.__getitem__, default="")
        if not vehicle or now_s - self.visits.since_s[vehicle] <= self._patience_s:
            return UNSET
        return DockWait(vehicle=vehicle, since_s=self.visits.since_s[vehicle])

    def on_ready(self, vehicle: str, now_s: float) -> bool:
        """The body has opened the dock for a vehicle; returns whether that vehicle waited here."""
        self._forget_silent(now_s)
        waited = self.visits.forget_request(vehicle)
        if waited is None:
            return False
        asked, entry = waited
        self._let_in(vehicle, entry)
        self.agree(vehicle, asked)
        # The body works, and the other vehicles have only waited for their turn: restart their clocks.
        self.visits.since_s = dict.fromkeys(self.visits.since_s, now_s)
        return True

    def _forget_silent(self, now_s: float) -> None:
        """Withdraw requests that are not repeated any more: the dock must not wait for a vehicle that has gone elsewhere."""
        silent = [
            vehicle
            for vehicle, at_s in self.visits.asked_s.items()
            if now_s - at_s > ASKS_STILL_S and vehicle not in self.visits.inside
        ]
        for vehicle in silent:
            self.shut(vehicle, "")

    def agree(self, vehicle: str, asked: Docked) -> None:
        """Tell a vehicle that it may load or unload at a dock that is not this agent's to open."""
        self._life.send(vehicle, DockOpened(task=asked.task, epoch=asked.epoch, station=asked.station))

    def hold(self, vehicle: str, asked: Docked, reason: str) -> None:
        """Tell a vehicle to wait."""
        held = DockHeld(task=asked.task, epoch=asked.epoch, station=asked.station, reason=reason)
        self._life.send(vehicle, held)

    def restore(self, opened: Iterable[str]) -> None:
        """Continue with the vehicles that an earlier life let in."""
        if self.visits.answers or not self.visits.counts:
            self.visits.inside.update(dict.fromkeys(opened, OF_EARLIER_LIFE))

    def shut(self, vehicle: str, task: str, load: DepartureMemory | None = None) -> None:
        """Withdraw a vehicle's permit: end a transfer without effect, or wait for it to leave.

        Ignored if the vehicle stands here for another task; that task's end shuts the dock.

        Args:
            vehicle: its id.
            task: its ended task; empty for any.
            load: what it may move meanwhile and nobody else would book; None for nothing.
        """
        asked, let_in = self.visits.asked.get(vehicle), self.visits.inside.get(vehicle)
        waits_for_another = bool(task) and asked is not None and asked[1].task != task
        if not waits_for_another:
            self.visits.forget_request(vehicle)
        if task and let_in is not None and let_in.task not in ("", task):
            return
        if waits_for_another and let_in is None:
            return
        self.visits.inside.pop(vehicle, None)
        is_left_to = self._departures.waits_for(vehicle) or self._booking_out.waits_for(vehicle)
        if self.visits.answers:
            if let_in is not None:
                self._watch(vehicle, let_in, load)
            if not self._departures.waits_for(vehicle):
                # An earlier life may have opened it.
                self._life.instruct(CloseDock(vehicle=vehicle))
            return
        # No moving dock can hurt the vehicle: close at once, and wait only for its load. A second call means
        # it has left.
        if let_in is not None or not is_left_to:
            self._life.instruct(CloseDock(vehicle=vehicle))
        if (
            let_in is not None
            and not self.visits.counts
            and (load is not None or not self._booking_out.waits_for(vehicle))
        ):
            self._watch(vehicle, let_in, load)

    def _watch(self, vehicle: str, let_in: Entry, load: DepartureMemory | None) -> None:
        """Watch a vehicle until it has left."""
        if load is not None and let_in.is_of(load):
            self._departures.watch(load)
        elif load is not None and let_in == OF_EARLIER_LIFE:
            # Whether it was let in for this load is unknown: book it out if in doubt, and in only on its own word.
            self._departures.watch(load if load.change < 0 else replace(load, let_in=False))
        else:
            self._departures.watch(DepartureMemory(vehicle))

    def close(self, vehicle: str, task: str) -> None:
        """A vehicle has done what it was let in for by a task."""
        if self.visits.inside.get(vehicle, OF_EARLIER_LIFE).task in ("", task):
            self.visits.inside.pop(vehicle, None)
        self.shut(vehicle, task)

    def note_moved(self, report: StockChanged, word: DepartureMemory | None = None) -> None:
        """The body has booked a vehicle's load: it is outside, unless it was let in for another load since.

        Args:
            report: the body's booking.
            word: the agent's report to the body; None if the body has counted by itself, or has answered before.
        """
        let_in = self.visits.inside.get(report.vehicle)
        if let_in is None:
            return
        if let_in == OF_EARLIER_LIFE:
            is_of_it = self.visits.counts or word is not None
        elif word is not None:
            is_of_it = let_in.is_of(word)
        else:
            is_of_it = self.visits.counts and (let_in.item, let_in.comes) == (report.item, report.change > 0)
        if is_of_it:
            del self.visits.inside[report.vehicle]

    def _let_in(self, vehicle: str, entry: Entry) -> None:
        self.visits.inside[vehicle] = entry
        self._departures.note_let_in(vehicle, entry.task, entry.epoch)
        self._booking_out.note_opened(vehicle)
