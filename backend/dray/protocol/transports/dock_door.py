"""The door of one dock: it opens for one vehicle and one load.

The dock's owner decides which vehicle may load or unload: a receiver asks its contracts (`transports.dock`), a
giver its reservations (`transports.issuing`).
"""

from __future__ import annotations

from msgspec import UNSET, UnsetType

from dray.body import OpenDock, StockChanged
from dray.memory import DepartureMemory
from dray.messages import Docked, DockHeld, DockOpened
from dray.messages.heartbeat import DockWait
from dray.plant import Plant
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life
from dray.protocol.transports.visit import Stage
from dray.protocol.transports.visits import Request, Visits

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

ASKED_KEPT = 16
"""Vehicles that have asked in vain one after the other, of which the waits are remembered: each waits for 15 s or more."""

NOT_READY = "the dock is not ready yet"
"""Reason for a vehicle to wait until the controller has made the dock safe."""

IN_DOUBT = "people look for loads that it has left in doubt"
"""Reason for a vehicle to wait until people have looked (`Doubts.has_too_many`)."""


class Door:
    """The door of one dock.

    Args:
        visits: the vehicles at it.
        patience_s: how long the body may take to open it.
    """

    def __init__(self, visits: Visits, patience_s: float, life: Life) -> None:
        self.visits, self._patience_s, self._life = visits, patience_s, life
        self._asked: BoundedMap[str, tuple[float, float]] = BoundedMap(ASKED_KEPT)
        """By vehicle that has asked since the dock last opened: since when, and when last (plant clock, s)."""

    def open(
        self, vehicle: str, asked: Docked, item: str, quantity: int, now_s: float, *, comes: bool
    ) -> None:
        """Let a vehicle unload (`comes`) or load, once; it waits while the body makes the dock ready."""
        self._life.instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity))
        load = DepartureMemory(vehicle, asked.task, asked.epoch, item, quantity if comes else -quantity)
        if self.visits.answers:
            self._forget_silent(now_s)
            before = self.visits.asked.get(vehicle)
            since_s = now_s if before is None else before.since_s
            self.visits.ask(Request(asked, load, since_s, now_s))
            self._asked[vehicle] = since_s, now_s
            self.hold(vehicle, asked, NOT_READY)
        else:
            self.visits.let_in(load)
            self.agree(vehicle, asked)

    def is_opening(self, vehicle: str) -> bool:
        """Whether a vehicle waits for the body to open the dock."""
        return vehicle in self.visits.asked

    def wait(self, now_s: float) -> DockWait | UnsetType:
        """The vehicle that has waited longest for the dock to open, if longer than `patience_s`.

        The waits of vehicles that have gone away since the dock last opened count, too.
        """
        asked = self.visits.asked
        vehicle = min(asked, key=lambda each: asked[each].since_s, default="")
        if not vehicle:
            return UNSET
        gone = (span for each, span in self._asked.items() if each not in asked)
        since_s = asked[vehicle].since_s - sum(last_s - first_s for first_s, last_s in gone)
        return DockWait(vehicle=vehicle, since_s=since_s) if now_s - since_s > self._patience_s else UNSET

    def on_ready(self, vehicle: str, now_s: float) -> bool:
        """The body has opened the dock for a vehicle; returns whether that vehicle waited here."""
        self._forget_silent(now_s)
        self._asked.clear()
        request = self.visits.forget_request(vehicle)
        if request is None:
            return False
        self.visits.let_in(request.load)
        self.agree(vehicle, request.docked)
        # The body works, and the other vehicles have only waited for their turn: restart their clocks.
        others = self.visits.asked.items()
        self.visits.asked = {each: waiting._replace(since_s=now_s) for each, waiting in others}
        return True

    def _forget_silent(self, now_s: float) -> None:
        """Withdraw requests that are not repeated any more: the dock must not wait for a vehicle that has gone elsewhere."""
        asked = self.visits.asked.items()
        silent = [vehicle for vehicle, request in asked if now_s - request.asked_s > ASKS_STILL_S]
        for vehicle in silent:
            if not self.visits.is_inside(vehicle):
                self.shut(vehicle, "")

    def agree(self, vehicle: str, asked: Docked) -> None:
        """Tell a vehicle that it may load or unload at a dock that is not this agent's to open."""
        self._life.send(vehicle, DockOpened(task=asked.task, epoch=asked.epoch, station=asked.station))

    def hold(self, vehicle: str, asked: Docked, reason: str) -> None:
        """Tell a vehicle to wait."""
        held = DockHeld(task=asked.task, epoch=asked.epoch, station=asked.station, reason=reason)
        self._life.send(vehicle, held)

    def shut(self, vehicle: str, task: str, load: DepartureMemory | None = None) -> None:
        """Withdraw a vehicle's permit: end a transfer without effect, or wait for it to leave.

        Ignored if the vehicle stands here for another task; that task's end shuts the dock.

        Args:
            vehicle: its id.
            task: its ended task; empty for any.
            load: what it may move meanwhile and nobody else would book; None for nothing.
        """
        asked, visit = self.visits.asked.get(vehicle), self.visits.get(vehicle)
        is_inside = visit is not None and visit.stage is Stage.INSIDE
        waits_for_another = bool(task) and asked is not None and asked.load.task != task
        if not waits_for_another:
            self.visits.forget_request(vehicle)
        if visit is not None and is_inside:
            if not task or visit.load.task in ("", task):
                self.visits.withdraw(visit, load)
        elif not waits_for_another and not self.visits.waits_for(vehicle):
            # An earlier life may have opened it.
            self.visits.dismiss(vehicle)

    def close(self, vehicle: str, task: str) -> None:
        """A vehicle has done what it was let in for by a task."""
        self.visits.note_done(vehicle, task)
        self.shut(vehicle, task)

    def note_moved(self, report: StockChanged, word: DepartureMemory | None = None) -> None:
        """The body has booked a vehicle's load: it is outside, unless it was let in for another load since.

        Args:
            report: the body's booking.
            word: the agent's report to the body; None if the body has counted by itself, or has answered before.
        """
        visit = self.visits.get(report.vehicle)
        if visit is None or visit.stage is not Stage.INSIDE:
            return
        load, counts = visit.load, self.visits.counts
        if visit.is_unnamed:
            is_of_it = counts or word is not None
        elif word is not None:
            is_of_it = visit.is_for(word.task, word.epoch)
        else:
            is_of_it = counts and load.item == report.item and load.brings is (report.change > 0)
        if is_of_it:
            self.visits.note_done(report.vehicle, load.task)
