"""Loads that others have fetched from a place whose body does not count: each is booked out once its vehicle says that it has it.

A vehicle that was let in to load is listened to. When it names the same task, in the same epoch, with the load on board, the body is told (`Book`).
When it names the task no more and never had it on board, it has left without.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.body import Book
from dray.memory import ReservationMemory
from dray.messages import AtvHeartbeat
from dray.messages.heartbeat import GOODS_ABOARD
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Effect, Instruct


class BookingOut:
    """Those who were let in to load at one place, and of whom it is not known yet whether they have.

    Args:
        subscriptions: whose heartbeats are heard.
        out: where effects go.
    """

    def __init__(self, subscriptions: HeartbeatSubscriptions, out: list[Effect]) -> None:
        self._subscriptions = subscriptions
        self._out = out
        self._let_in: dict[str, ReservationMemory] = {}
        """By vehicle, what it may take."""

    def let_in(self, load: ReservationMemory) -> None:
        """A vehicle may load now. Harmless when that was said before."""
        if load.vehicle not in self._let_in:
            self._subscriptions.follow(load.vehicle)
        self._let_in[load.vehicle] = load

    def on_carrier_heard(self, heartbeat: AtvHeartbeat) -> None:
        """A vehicle may have left with a load."""
        load, carries = self._let_in.get(heartbeat.atv), heartbeat.task
        if load is None:
            return
        if carries is None or (carries.task, carries.epoch) != (load.task, load.opened):
            self._forget(load.vehicle)
        elif carries.phase in GOODS_ABOARD:
            self._out.append(
                Instruct(
                    Book(load.vehicle, load.item, -load.quantity, task=load.task, epoch=load.opened),
                )
            )
            self._forget(load.vehicle)

    def memories(self) -> tuple[ReservationMemory, ...]:
        """For the next life, which hears the vehicle in this one's place."""
        return tuple(self._let_in.values())

    def restore(self, memories: Iterable[ReservationMemory]) -> None:
        """Go on listening to whom an earlier life has let in."""
        for load in memories:
            self.let_in(load)

    def _forget(self, vehicle: str) -> None:
        del self._let_in[vehicle]
        self._subscriptions.unfollow(vehicle)
