"""Docks: where vehicles stand to load or unload, and the door that opens for one vehicle and one load.

The dock's owner decides which vehicle may load or unload: a receiver asks its contracts (`transports.dock`), a
giver its reservations (`transports.issuing`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from msgspec import UNSET, UnsetType
from msgspec.structs import replace

from dray.body import CloseDock, OpenDock, StockChanged
from dray.memory import DepartureMemory
from dray.messages import Docked, DockHeld, DockOpened, Transport
from dray.messages.heartbeat import DockWait
from dray.plant import Plant
from dray.protocol.contract_net.departures import Departures
from dray.protocol.runtime.life import Life


def dock_of(plant: Plant, work: Transport, place: str) -> str:
    """The node where vehicles dock at a source or at the destination of a transport.

    Args:
        plant: the plant file's plant.
        work: the transport; it gives the position of a joining machine.
        place: one of its places.

    Returns:
        A node; empty if the place is unknown.
    """
    if plant.has_place(place):
        return plant.node_of(place)
    return place if place == work.handed_at else work.node


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


NOT_READY = "the dock is not ready yet"
"""Reason for a vehicle to wait until the controller has made the dock safe."""


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


class Door:
    """The door of one dock.

    Args:
        patience_s: how long the body may take to open it.
        departures: of this dock.
        is_told_of: whether a vehicle that was let in to take a load, and is not wanted any more, is still to report
            on it.

    Attributes:
        answers: whether the body reports when it has opened (`dray.body.WorkcellState`); otherwise it is open at
            once.
        counts: whether the body counts what vehicles bring and take.
    """

    def __init__(
        self,
        life: Life,
        patience_s: float,
        departures: Departures,
        is_told_of: Callable[[str], bool] = lambda _vehicle: False,
    ) -> None:
        self._life, self._patience_s, self._departures = life, patience_s, departures
        self._is_told_of = is_told_of
        self._asked: dict[str, tuple[Docked, Entry]] = {}
        """By vehicle: its request that waits for the dock to open."""
        self._since_s: dict[str, float] = {}
        """By vehicle: since when it is the next one (plant clock, s)."""
        self._inside: dict[str, Entry] = {}
        """Vehicles that were let in and may be inside."""
        self.answers = False
        self.counts = True

    def open(
        self, vehicle: str, asked: Docked, item: str, quantity: int, now_s: float, *, comes: bool
    ) -> None:
        """Let a vehicle unload (`comes`) or load, once; it waits while the body makes the dock ready."""
        self._life.instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity))
        entry = Entry(asked.task, asked.epoch, item, comes)
        if self.answers:
            self._asked[vehicle] = asked, entry
            self._since_s.setdefault(vehicle, now_s)
            self.hold(vehicle, asked, NOT_READY)
        else:
            self._let_in(vehicle, entry)
            self.agree(vehicle, asked)

    def is_opening(self, vehicle: str) -> bool:
        """Whether a vehicle waits for the body to open the dock."""
        return vehicle in self._asked

    def wait(self, now_s: float) -> DockWait | UnsetType:
        """The vehicle that has waited longest for the dock to open, if longer than `patience_s`."""
        vehicle = min(self._since_s, key=self._since_s.__getitem__, default="")
        if not vehicle or now_s - self._since_s[vehicle] <= self._patience_s:
            return UNSET
        return DockWait(vehicle=vehicle, since_s=self._since_s[vehicle])

    def on_ready(self, vehicle: str, now_s: float) -> bool:
        """The body has opened the dock for a vehicle; returns whether that vehicle waited here."""
        waited = self._forget(vehicle)
        if waited is None:
            return False
        asked, entry = waited
        self._let_in(vehicle, entry)
        self.agree(vehicle, asked)
        # The body works, and the other vehicles have only waited for their turn: restart their clocks.
        self._since_s = dict.fromkeys(self._since_s, now_s)
        return True

    def agree(self, vehicle: str, asked: Docked) -> None:
        """Tell a vehicle that it may load or unload at a dock that is not this agent's to open."""
        self._life.send(vehicle, DockOpened(task=asked.task, epoch=asked.epoch, station=asked.station))

    def hold(self, vehicle: str, asked: Docked, reason: str) -> None:
        """Tell a vehicle to wait."""
        held = DockHeld(task=asked.task, epoch=asked.epoch, station=asked.station, reason=reason)
        self._life.send(vehicle, held)

    def restore(self, opened: Iterable[str]) -> None:
        """Continue with the vehicles that an earlier life let in."""
        if self.answers or not self.counts:
            self._inside.update(dict.fromkeys(opened, OF_EARLIER_LIFE))

    def shut(self, vehicle: str, task: str, load: DepartureMemory | None = None) -> None:
        """Withdraw a vehicle's permit: end a transfer without effect, or wait for it to leave.

        Ignored if the vehicle stands here for another task; that task's end shuts the dock.

        Args:
            vehicle: its id.
            task: its ended task; empty for any.
            load: what it may move meanwhile and nobody else would book; None for nothing.
        """
        asked, let_in = self._asked.get(vehicle), self._inside.get(vehicle)
        waits_for_another = bool(task) and asked is not None and asked[1].task != task
        if not waits_for_another:
            self._forget(vehicle)
        if task and let_in is not None and let_in.task not in ("", task):
            return
        if waits_for_another and let_in is None:
            return
        self._inside.pop(vehicle, None)
        is_left_to = self._departures.waits_for(vehicle) or self._is_told_of(vehicle)
        if self.answers:
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
        if let_in is not None and not self.counts and (load is not None or not self._is_told_of(vehicle)):
            self._watch(vehicle, let_in, load)

    def _watch(self, vehicle: str, let_in: Entry, load: DepartureMemory | None) -> None:
        """Watch a vehicle until it has left."""
        if load is not None and let_in.is_of(load):
            self._departures.watch(load)
        elif load is not None and let_in == OF_EARLIER_LIFE:
            # Whether it was let in for this load is unknown: book it out if in doubt, never in.
            self._departures.watch(replace(load, change=min(load.change, 0)))
        else:
            self._departures.watch(DepartureMemory(vehicle))

    def close(self, vehicle: str, task: str) -> None:
        """A vehicle has done what it was let in for by a task."""
        if self._inside.get(vehicle, OF_EARLIER_LIFE).task in ("", task):
            self._inside.pop(vehicle, None)
        self.shut(vehicle, task)

    def note_moved(self, report: StockChanged, word: DepartureMemory | None = None) -> None:
        """The body has booked a vehicle's load: it is outside, unless it was let in for another load since.

        Args:
            report: the body's booking.
            word: the agent's report to the body; None if the body has counted by itself, or has answered before.
        """
        let_in = self._inside.get(report.vehicle)
        if let_in is None:
            return
        if let_in == OF_EARLIER_LIFE:
            is_of_it = self.counts or word is not None
        elif word is not None:
            is_of_it = let_in.is_of(word)
        else:
            is_of_it = self.counts and (let_in.item, let_in.comes) == (report.item, report.change > 0)
        if is_of_it:
            del self._inside[report.vehicle]

    def note_left(self, vehicle: str) -> None:
        """A vehicle has left without the load it was let in for: tell a body that waits for its report."""
        if (
            not self.answers
            and not self.counts
            and vehicle not in self._inside
            and not self._departures.waits_for(vehicle)
        ):
            self._life.instruct(CloseDock(vehicle=vehicle))

    def on_departed(self, vehicle: str, task: str) -> None:
        """A watched vehicle has left; forget its request for that task (empty if the task is unknown).

        Its later requests stay.
        """
        self._inside.pop(vehicle, None)
        if vehicle in self._asked and self._asked[vehicle][1].task == task:
            self._forget(vehicle)

    def on_carried_away(self, vehicle: str) -> None:
        """People have carried a vehicle away: forget its requests."""
        self._inside.pop(vehicle, None)
        self._forget(vehicle)

    def _let_in(self, vehicle: str, entry: Entry) -> None:
        self._inside[vehicle] = entry
        self._departures.note_let_in(vehicle, entry.task, entry.epoch)

    def _forget(self, vehicle: str) -> tuple[Docked, Entry] | None:
        self._since_s.pop(vehicle, None)
        return self._asked.pop(vehicle, None)
