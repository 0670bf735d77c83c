"""Vehicles that may still be at a dock though they are not wanted there any more: the dock stays open until each has left.

A transport is cancelled, or taken over, while its vehicle loads or unloads. A dock that makes itself safe (`Door.answers`) must not be given back
to its controller then: the vehicle's forks may be inside. Its heartbeat tells when it is done. It is at it as long as it stands at the node of the
dock and loads, unloads, or has just been told to bring its load back. A vehicle that is silent is still there, for all that anybody knows; one that
people have carried away is not.

What it has put down or taken meanwhile lies there, or lies there no more, whoever its transport belongs to by now. A body that does not count is
told so (`Book`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from dray.body import Book, CloseDock
from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Phase
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Effect, Instruct

_MAY_BE_INSIDE = frozenset({Phase.LOADING, Phase.UNLOADING, Phase.RETURNING})


class Departures:
    """Of one dock.

    Args:
        node: where vehicles stand at it.
        subscriptions: whose heartbeats are heard.
        out: where effects go.
        commit: called when the next life must know of something else.
        left: called with a vehicle that has left.
    """

    def __init__(
        self,
        node: str,
        subscriptions: HeartbeatSubscriptions,
        out: list[Effect],
        commit: Callable[[], None],
        left: Callable[[str], None] = lambda _vehicle: None,
    ) -> None:
        self._node, self._subscriptions, self._out, self._commit = node, subscriptions, out, commit
        self._left = left
        self._leaving: dict[str, DepartureMemory] = {}
        """By vehicle, what it may have moved."""

    def watch(self, load: DepartureMemory) -> None:
        """A vehicle is not wanted any more, and may be inside. Harmless when that is known."""
        if load.vehicle not in self._leaving:
            self._subscriptions.follow(load.vehicle)
            self._leaving[load.vehicle] = load
            self._commit()

    def take_back(self, load: DepartureMemory) -> None:
        """A vehicle that has its load on board stands here to put it down. Harmless when that is known; of what it was watched for before nothing was put down."""
        known = self._leaving.get(load.vehicle)
        if known is not None and known != load:
            if known.item == load.item and known.change < 0:
                self._book(known)
            self._leaving[load.vehicle] = load
            self._commit()
        self.watch(load)

    def note_done(self, vehicle: str, *, aboard: bool) -> None:
        """A vehicle is done here. Harmless when it was not watched.

        Args:
            vehicle: which.
            aboard: whether it has its load on board.
        """
        load = self._leaving.get(vehicle)
        if load is None:
            return
        if load.change and aboard is (load.change < 0):
            self._book(load)
        self._close(vehicle)

    def on_vehicle(self, heartbeat: AtvHeartbeat) -> None:
        """A vehicle tells where it is, and what it does."""
        load = self._leaving.get(heartbeat.atv)
        if load is None:
            return
        phase = heartbeat.task.phase if heartbeat.task is not None else None
        if heartbeat.node != self._node or phase not in _MAY_BE_INSIDE:
            self.note_done(heartbeat.atv, aboard=heartbeat.load == load.item and heartbeat.load_quantity > 0)

    def on_carried_away(self, vehicle: str) -> None:
        """People have carried a vehicle away: what it has put down before nobody knows, and nothing is booked."""
        if vehicle in self._leaving:
            self._close(vehicle)

    # --- over a restart ---

    def memories(self) -> tuple[DepartureMemory, ...]:
        """For the next life, which hears the vehicle in this one's place."""
        return tuple(self._leaving.values())

    def restore(self, memories: Iterable[DepartureMemory]) -> None:
        """Go on listening to whom an earlier life has waited for."""
        for load in memories:
            self.watch(load)

    def _book(self, load: DepartureMemory) -> None:
        book = Book(load.vehicle, load.item, load.change, task=load.task, epoch=load.epoch)
        self._out.append(Instruct(book))

    def _close(self, vehicle: str) -> None:
        del self._leaving[vehicle]
        self._subscriptions.unfollow(vehicle)
        self._out.append(Instruct(CloseDock(vehicle=vehicle)))
        self._left(vehicle)
        self._commit()
