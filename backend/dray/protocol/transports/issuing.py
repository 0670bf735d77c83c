"""Loads that others have fetched here: reservations, and the vehicles for which the dock opens to load.

The coordinator of a transport asks for its load before it hires a vehicle (`sourcing`). A storage's station gives
out what lies in the storage; a machine gives out what is to be taken from its buffers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from dray.messages import Docked, Message, StockAsked, StockFreed, StockReserved, StockShort
from dray.protocol.runtime.life import Change, Life
from dray.protocol.runtime.shutdown import GracefulShutdown
from dray.protocol.transports.dock_door import IN_DOUBT, Door
from dray.protocol.transports.reservations import Ask, Reservations

LAPSE = "lapse"

NOT_KEPT = "a request for material that is not kept here"
TOO_MANY = "a request above the limit of one coordinator"
ANOTHERS = "a request that differs from the first one for its task, or comes from another agent"
FETCHED = "a request for material that was fetched already"
DRAINING = "a request while the station is draining"


@dataclass(frozen=True, slots=True)
class ReservationsChanged(Change):
    """The reservations of a place have changed: what is free may be reserved for the next (`Issuing.settle`)."""


class Issuing:
    """The loads that one place gives out.

    Args:
        place: the place's id.
        book: its stock and reservations.
        life: the agent's life; alarms are named `LAPSE`.
        door: the door of its dock.
        shutdown: of its agent, which sets nothing aside while it drains.

    Attributes:
        message_handlers, alarms: entries for the agent's tables.
    """

    def __init__(
        self,
        place: str,
        book: Reservations,
        life: Life,
        door: Door,
        shutdown: GracefulShutdown,
    ) -> None:
        self._place = place
        self._book = book
        self._life = life
        self._shutdown = shutdown
        self._door = door
        self.message_handlers: Mapping[type[Message], Callable[..., None]] = {
            StockAsked: self._on_asked,
            StockFreed: self._on_freed,
        }
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {LAPSE: self._lapse}

    # --- reservations ---

    def _on_asked(self, sender: str, asked: StockAsked, now_s: float) -> None:
        known = self._book.get(asked.task)
        if reason := self._refusal(sender, asked, known):
            self._life.ignore(reason)
            return
        ask = self._book.ask(asked, sender, now_s)
        if ask.reserved:
            self._say_reserved(ask)
        self._changed(now_s)
        if not ask.reserved:
            self._say_short(ask)

    def _refusal(self, sender: str, asked: StockAsked, known: Ask | None) -> str:
        """Why a request is ignored; empty if it is answered."""
        if not self._book.holds(asked.item, asked.quantity):
            return NOT_KEPT
        if self._book.was_taken(asked.task, asked.epoch):
            return FETCHED
        if known is not None:
            same = (known.item, known.quantity) == (asked.item, asked.quantity)
            return "" if same and known.coordinator in ("", sender) else ANOTHERS
        if self._shutdown.begun:
            return DRAINING
        return TOO_MANY if self._book.has_too_many(sender) else ""

    def _on_freed(self, sender: str, freed: StockFreed, now_s: float) -> None:
        if self._door.visits.on_freed(sender, freed):
            return  # The body reports that it is gone.
        if freed.epoch:
            return  # The reservation serves a later epoch.
        ask = self._book.get(freed.task)
        if ask is None or ask.coordinator != sender:
            self._life.ignore("a release of a reservation that the sender does not have")
            return
        self._release(ask)
        self._changed(now_s)

    def _lapse(self, _about: None, now_s: float) -> None:
        for ask in self._book.lapsed(now_s):
            self._release(ask)
        self._changed(now_s)

    def _release(self, ask: Ask) -> None:
        self._book.release(ask)
        if ask.opened:
            self._door.shut(ask.vehicle, ask.task)

    # --- the dock ---

    def on_docked(self, sender: str, docked: Docked, now_s: float) -> None:
        """A vehicle stands here and asks to load."""
        self._door.visits.on_docked(sender, docked, now_s, unloads=False)
        ask = self._book.get(docked.task)
        if self._door.visits.doubts.has_too_many(sender):
            self._door.hold(sender, docked, IN_DOUBT)
            return
        if ask is None or not ask.reserved:
            ask = self._stand(sender, docked, now_s)
        if ask is None:
            self._door.hold(sender, docked, f"{self._place} does not keep this")
        elif not ask.reserved:
            self._door.hold(sender, docked, f"{self._place} has no {ask.item}")
        elif not ask.is_of_its_carrier(sender, docked.epoch):
            self._door.hold(sender, docked, "another vehicle fetches it")
        else:
            self._open(sender, docked, ask, now_s)

    def shut_unknown(self, opened: Iterable[str]) -> None:
        """Shut the dock for vehicles of an earlier life that are unknown now."""
        known = {ask.vehicle for ask in self._book if ask.opened}
        for vehicle in opened:
            if vehicle not in known:
                self._door.shut(vehicle, "")

    def on_taken(self, vehicle: str, item: str) -> None:
        """The body has counted an item fetched by a vehicle."""
        self._book.take(vehicle, item)

    def _stand(self, sender: str, docked: Docked, now_s: float) -> Ask | None:
        """Queue a vehicle without a reservation before all others, while it keeps asking."""
        if not self._book.holds(docked.item, docked.quantity):
            return None
        asked = StockAsked(docked.task, docked.epoch, docked.item, docked.quantity)
        ask = self._book.stand(sender, asked, now_s)
        self._changed(now_s)
        return ask

    def _open(self, vehicle: str, docked: Docked, ask: Ask, now_s: float) -> None:
        if ask.opened and ask.vehicle != vehicle:
            self._door.shut(ask.vehicle, ask.task)
        ask.open(vehicle, docked.epoch, now_s)
        self._book.renew(ask, now_s)
        self._door.open(vehicle, docked, ask.item, ask.quantity, now_s, comes=False)
        self._door.visits.expect(ask.load(), now_s)
        self._changed(now_s)

    # --- consequences ---

    def _changed(self, now_s: float) -> None:
        """Have the agent react at once: what this step does next depends on it."""
        self._life.note(ReservationsChanged())
        self._life.settle(now_s)

    @property
    def is_held(self) -> bool:
        """Whether a vehicle may load now."""
        return any(ask.opened for ask in self._book)

    def settle(self, now_s: float) -> None:
        """Reserve free pieces, and cancel reservations that the stock does not cover."""
        for ask in self._book.overdrawn():
            if ask.vehicle:
                self._door.shut(ask.vehicle, ask.task)
            self._say_short(ask)
        for ask in self._book.promise(now_s):
            self._say_reserved(ask)
        self._life.alarm(LAPSE, self._book.next_lapse_s)

    def _say_reserved(self, ask: Ask) -> None:
        if ask.coordinator:
            reserved = StockReserved(task=ask.task, epoch=ask.epoch, item=ask.item, quantity=ask.quantity)
            self._life.send(ask.coordinator, reserved)

    def _say_short(self, ask: Ask) -> None:
        if ask.coordinator:
            free = max(0, self._book.free(ask.item))
            short = StockShort(task=ask.task, epoch=ask.epoch, item=ask.item, free=free)
            self._life.send(ask.coordinator, short)
