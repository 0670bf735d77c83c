"""Docks: where vehicles stand at the places of a transport, and the door that opens for one vehicle and one load.

Who may load or unload is for the dock's owner to know: whoever receives a load asks its contracts
(`transports.dock`), whoever gives one its reservations (`transports.issuing`).
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
        plant: as the plant file has it.
        work: the transport; one of a joining machine tells where that stands.
        place: a place of it.

    Returns:
        A node; empty when nobody knows the place.
    """
    if plant.has_place(place):
        return plant.node_of(place)
    return place if place == work.handed_at else work.node


SAFE_WITHIN_S = 60.0
"""A dock at which nothing moves any more is made safe within this: a door shuts, a conveyor runs empty."""


def ready_within_s(plant: Plant, place: str) -> float:
    """How long a dock may take to get ready before somebody should look: what is being made there may be ended first.

    Args:
        plant: as the plant file has it.
        place: whose dock.
    """
    spec = plant.machines.get(place)
    return (
        SAFE_WITHIN_S + max((making.cycle_s for making in spec.makes), default=0.0) if spec else SAFE_WITHIN_S
    )


NOT_READY = "the dock is not ready yet"
"""To a vehicle, while whoever makes the dock safe has not said that it is."""


class Entry(NamedTuple):
    """What a vehicle has asked the dock for, and is let in for."""

    task: str
    epoch: int
    item: str
    comes: bool
    """It unloads; else it loads."""

    def is_of(self, load: DepartureMemory) -> bool:
        """Whether a load is what it is let in for."""
        return (self.task, self.epoch) == (load.task, load.epoch)


OF_EARLIER_LIFE = Entry("", 0, "", comes=False)
"""For what an earlier life has let somebody in: not known."""


class Door:
    """The door of one dock.

    Args:
        patience_s: so long the body may take to open it.
        departures: of this dock.
        is_told_of: whether it is still waited for what a vehicle has to tell of a load that it was let in to take, though it is not wanted any more.

    Attributes:
        answers: whether the body says when it has opened (`dray.body.WorkcellState`); else it is open as soon as it is told to.
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
        """By vehicle, what it has asked for and waits to be opened."""
        self._since_s: dict[str, float] = {}
        """Since when each of them is the next one."""
        self._inside: dict[str, Entry] = {}
        """Those that were let in: they may be at it."""
        self.answers = False
        self.counts = True

    def open(
        self, vehicle: str, asked: Docked, item: str, quantity: int, now_s: float, *, comes: bool
    ) -> None:
        """Let a vehicle that stands here unload (`comes`) or load, once; it waits where the body has to make the dock ready for it."""
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
        """Whether a vehicle waits for the body to open."""
        return vehicle in self._asked

    def wait(self, now_s: float) -> DockWait | UnsetType:
        """Who has waited for too long for the body to open, the longest of them."""
        vehicle = min(self._since_s, key=self._since_s.__getitem__, default="")
        if not vehicle or now_s - self._since_s[vehicle] <= self._patience_s:
            return UNSET
        return DockWait(vehicle=vehicle, since_s=self._since_s[vehicle])

    def on_ready(self, vehicle: str, now_s: float) -> bool:
        """The body has opened the dock for a vehicle; whether that has waited for it here."""
        waited = self._forget(vehicle)
        if waited is None:
            return False
        asked, entry = waited
        self._let_in(vehicle, entry)
        self.agree(vehicle, asked)
        # It gets ready: whoever waits behind this one has waited for that one's turn.
        self._since_s = dict.fromkeys(self._since_s, now_s)
        return True

    def agree(self, vehicle: str, asked: Docked) -> None:
        """Tell a vehicle that it may load or unload, without opening a dock: it is not this agent's."""
        self._life.send(vehicle, DockOpened(task=asked.task, epoch=asked.epoch, station=asked.station))

    def hold(self, vehicle: str, asked: Docked, reason: str) -> None:
        """Let it wait."""
        held = DockHeld(task=asked.task, epoch=asked.epoch, station=asked.station, reason=reason)
        self._life.send(vehicle, held)

    def restore(self, opened: Iterable[str]) -> None:
        """Go on with a dock that an earlier life has opened."""
        if self.answers or not self.counts:
            self._inside.update(dict.fromkeys(opened, OF_EARLIER_LIFE))

    def shut(self, vehicle: str, task: str, load: DepartureMemory | None = None) -> None:
        """A vehicle is not wanted any more: end a transfer that it has begun without effect, or let it leave where it may be inside.

        Harmless where it stands here for another task, whose own end shuts the dock.

        Args:
            vehicle: which.
            task: for which it is not wanted; empty for any.
            load: what it may move meanwhile, and nobody else would book; None for nothing.
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
                # Also when this life has not opened it: an earlier one may have.
                self._life.instruct(CloseDock(vehicle=vehicle))
            return
        # Nothing moves that could hurt it: the permit goes at once, and only what it moves is waited for. Said twice, it has left.
        if let_in is not None or not is_left_to:
            self._life.instruct(CloseDock(vehicle=vehicle))
        if let_in is not None and not self.counts and (load is not None or not self._is_told_of(vehicle)):
            self._watch(vehicle, let_in, load)

    def _watch(self, vehicle: str, let_in: Entry, load: DepartureMemory | None) -> None:
        """Wait until it has left, for what it was let in for."""
        if load is not None and let_in.is_of(load):
            self._departures.watch(load)
        elif load is not None and let_in == OF_EARLIER_LIFE:
            # Whether for this load nobody knows: in doubt it is booked out, and never in.
            self._departures.watch(replace(load, change=min(load.change, 0)))
        else:
            self._departures.watch(DepartureMemory(vehicle))

    def close(self, vehicle: str, task: str) -> None:
        """A vehicle has done what it was let in for by a task."""
        if self._inside.get(vehicle, OF_EARLIER_LIFE).task in ("", task):
            self._inside.pop(vehicle, None)
        self.shut(vehicle, task)

    def note_moved(self, report: StockChanged, word: DepartureMemory | None = None) -> None:
        """What a vehicle has moved is booked: it is inside no more, unless it was let in for something else since. What it has asked for still waits.

        Args:
            report: what the body has booked.
            word: what its agent had told the body of it; None where the body has counted it by itself, or has answered before.
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
        """A vehicle that was let in to load has left without, and tells no more of it: a body that waits for its word is told."""
        if (
            not self.answers
            and not self.counts
            and vehicle not in self._inside
            and not self._departures.waits_for(vehicle)
        ):
            self._life.instruct(CloseDock(vehicle=vehicle))

    def on_departed(self, vehicle: str, task: str) -> None:
        """A vehicle has left that was watched for a task, empty where nobody knows for which: it waits for nothing of that any more.

        What it has asked for since still waits.
        """
        self._inside.pop(vehicle, None)
        if vehicle in self._asked and self._asked[vehicle][1].task == task:
            self._forget(vehicle)

    def on_carried_away(self, vehicle: str) -> None:
        """People have carried a vehicle away: it waits for nothing here any more."""
        self._inside.pop(vehicle, None)
        self._forget(vehicle)

    def _let_in(self, vehicle: str, entry: Entry) -> None:
        self._inside[vehicle] = entry
        self._departures.note_let_in(vehicle, entry.task, entry.epoch)

    def _forget(self, vehicle: str) -> tuple[Docked, Entry] | None:
        self._since_s.pop(vehicle, None)
        return self._asked.pop(vehicle, None)
