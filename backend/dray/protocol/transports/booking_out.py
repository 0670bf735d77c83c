"""Loads fetched by others from a place whose body does not count: each is booked out once its vehicle reports it on board.

The place follows the heartbeats of a vehicle that was let in to load:

    it names the task, in the same epoch, with the load on board    booked out: the body is told (`Book`)
    it names the task no more, and stands here still                its body may go on loading, although its agent was started
                                                                    again or has lost the task: what it leaves with counts
    it names the task no more, and was heard at it until then       it has left without, unless such a load is on board
    it names the task no more before the dock was opened for it     its body has not begun to load, and will not: it leaves without
    it names the task no more, after a time in which it was not     its coordinator is asked until it answers whether the load was
    heard (this agent was down, or deaf)                            fetched, or that it cannot know. In doubt it is booked out:
                                                                    nothing is promised that may not lie there
    an earlier life let it in, and no notes say for which task      the same, by what it has on board when it leaves
    it has lost its memory here, and left with nothing on board     it has left without, whatever it has on board now (`left_empty`)
    it was heard elsewhere without the load                         what it has on board later is not from here, unless it names
                                                                    the task

The question is `StockReserved`. A coordinator that needs the pieces no more answers with `StockFreed`.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from dray.memory import DepartureMemory, ReservationMemory
from dray.messages import AtvHeartbeat, Docked, StockFreed, StockReserved
from dray.messages.heartbeat import GOODS_ABOARD
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.life import Life
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.departures import UNHEARD_S, Departures

AGAIN_S = 10.0
"""Time after which a silent coordinator is asked again (s)."""


class BookingOut:
    """Vehicles that were let in to load at one place, and have not reported the result yet.

    Args:
        node: where vehicles stand at its dock.
        subscriptions: for following vehicles' heartbeats.
        bookings: reports to the place's body.
        departures: vehicles that may still be at its dock.
    """

    def __init__(
        self,
        node: str,
        subscriptions: HeartbeatSubscriptions,
        bookings: Bookings,
        departures: Departures,
        life: Life,
    ) -> None:
        self._node, self._subscriptions, self._bookings = node, subscriptions, bookings
        self._departures, self._life = departures, life
        self._let_in: dict[str, ReservationMemory] = {}
        """By vehicle: the load that it may take."""
        self._heard_s: dict[str, float] = {}
        """By vehicle: when it was last heard or seen at its task; only those that this life has heard."""
        self._asked_s: dict[str, float] = {}
        """By vehicle: when its coordinator was last asked whether it has fetched the load."""
        self._shut: set[str] = set()
        """Vehicles for which the dock was not opened since they are followed."""

    def let_in(self, load: ReservationMemory, now_s: float, *, is_shut: bool) -> None:
        """A vehicle stands here and may load once the dock is open. Repeating this is harmless.

        Args:
            load: what it may take.
            now_s: the present time.
            is_shut: whether the dock was not opened for it yet.
        """
        if is_shut and load.vehicle not in self._let_in:
            self._shut.add(load.vehicle)
        self._follow(load)
        self._heard_s[load.vehicle] = now_s
        self._asked_s.pop(load.vehicle, None)
        self._life.commit()

    def note_opened(self, vehicle: str) -> None:
        """The dock was opened for a vehicle. Others than the followed ones are ignored."""
        self._shut.discard(vehicle)

    def on_carrier_heard(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Handle a heartbeat: the vehicle may have left with a load."""
        load, carries = self._let_in.get(heartbeat.atv), heartbeat.task
        if load is None:
            return
        if carries is not None and (carries.task, carries.epoch) == (load.task, load.opened):
            self._heard_s[load.vehicle] = now_s
            load = self._mark(load, ended=False)
            if carries.phase in GOODS_ABOARD:
                self._book(load)
            return
        if load.vehicle in self._shut:
            load = self._mark(load, ended=True)
        is_here, was_heard = heartbeat.node == self._node, self._was_heard(load, now_s)
        left_empty = heartbeat.left_empty == self._node
        has_it = heartbeat.load == load.item and heartbeat.load_quantity > 0 and not left_empty
        if has_it and self._may_be_from_here(load, is_known=is_here or was_heard):
            self._book(load)
        elif is_here and not load.gone and (carries is None or was_heard or not load.task):
            self._heard_s[load.vehicle] = now_s
        elif left_empty or was_heard or load.ended:
            self._leave(load.vehicle)
            if not is_here:
                self._departures.on_elsewhere(load.vehicle, load.task)
        else:
            self._ask(self._mark(load, gone=load.gone or not is_here), now_s)

    def on_docked(self, vehicle: str, docked: Docked, now_s: float) -> None:
        """A vehicle stands here, perhaps for another load before it has reported the last one.

        Called before the dock is opened for it: a body shuts its dock when it books.
        """
        load = self._let_in.get(vehicle)
        if load is None or (docked.task, docked.epoch) == (load.task, load.opened):
            return
        asks_again = not load.task and docked.item == load.item
        if self._was_heard(load, now_s) or load.ended or asks_again:
            self._leave(vehicle)
        else:
            self._book(load)

    def note_aboard(self, vehicle: str, item: str) -> None:
        """A vehicle has this item on board: if it was let in for it, it took it here."""
        load = self._let_in.get(vehicle)
        if load is not None and load.item == item:
            self._book(load)

    def on_freed(self, sender: str, freed: StockFreed) -> bool:
        """A coordinator frees pieces, and tells whether they were fetched. Returns whether they were booked out."""
        for vehicle in list(self._asked_s):
            load = self._let_in[vehicle]
            if (load.task, load.coordinator) != (freed.task, sender):
                continue
            if freed.fetched:
                self._book(load)
                return True
            self._leave(vehicle)
        return False

    def waits_for(self, vehicle: str) -> bool:
        """Whether a vehicle may still report the load that it was let in for."""
        return vehicle in self._let_in

    def memories(self) -> tuple[ReservationMemory, ...]:
        """The followed vehicles' loads, for the next life."""
        return tuple(self._let_in.values())

    def restore(self, memories: Iterable[ReservationMemory]) -> None:
        """Go on following the vehicles that an earlier life has let in."""
        for load in memories:
            self._follow(load)

    def _follow(self, load: ReservationMemory) -> None:
        if load.vehicle not in self._let_in:
            self._subscriptions.follow(load.vehicle)
        self._let_in[load.vehicle] = load

    def _mark(self, load: ReservationMemory, **marks: bool) -> ReservationMemory:
        """Keep a load with other marks, over a restart too. Returns it."""
        marked = replace(load, **marks)
        if marked != load:
            self._let_in[load.vehicle] = marked
            self._life.commit()
        return marked

    def _may_be_from_here(self, load: ReservationMemory, *, is_known: bool) -> bool:
        """Whether a vehicle that does not name the task may have taken here what it has on board.

        Args:
            load: what it may have taken.
            is_known: whether the vehicle is here, or was until just now.
        """
        if load.gone or load.vehicle in self._shut:
            return False
        return is_known or not load.ended

    def _was_heard(self, load: ReservationMemory, now_s: float) -> bool:
        """Whether a vehicle was recently heard at its task."""
        return now_s - self._heard_s.get(load.vehicle, -UNHEARD_S) < UNHEARD_S

    def _ask(self, load: ReservationMemory, now_s: float) -> None:
        if not load.coordinator:
            self._book(load)  # No coordinator to ask: only a vehicle has named it, or the body.
        elif now_s - self._asked_s.get(load.vehicle, -AGAIN_S) >= AGAIN_S:
            self._asked_s[load.vehicle] = now_s
            asked = StockReserved(load.task, load.opened, load.item, load.quantity)
            self._life.send(load.coordinator, asked)

    def _book(self, load: ReservationMemory) -> None:
        self._bookings.say(DepartureMemory(load.vehicle, load.task, load.opened, load.item, -load.quantity))
        self._forget(load.vehicle)

    def _leave(self, vehicle: str) -> None:
        """A vehicle has left without its load."""
        self._departures.note_left(vehicle)
        self._forget(vehicle)

    def _forget(self, vehicle: str) -> None:
        del self._let_in[vehicle]
        self._heard_s.pop(vehicle, None)
        self._asked_s.pop(vehicle, None)
        self._shut.discard(vehicle)
        self._subscriptions.unfollow(vehicle)
        self._life.commit()
