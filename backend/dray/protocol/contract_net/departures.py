"""Vehicles that may still be at a dock though they are not wanted there any more: the dock stays open until each has left.

A transport is cancelled, or taken over, while its vehicle loads or unloads. A dock that makes itself safe (`Door.answers`) must not be given back
to its controller then: the vehicle's forks may be inside. Its heartbeat tells when it is done. It is at it as long as it stands at the node of the
dock and loads, unloads, or has just been told to bring its load back. A vehicle that is silent is still there, for all that anybody knows; one that
people have carried away is not.

What it has put down or taken meanwhile lies there, or lies there no more, whoever its transport belongs to by now. A body that does not count is
told so (`Book`).

    it names the task, brings back or has its load on board    it has taken it, or not put it down
    it names the task, without                                 it has put it down, or not taken it
    it names the task no more, and was heard at it until then  the same: nobody ends a task with its load on board
    it has brought its load back, and was not let in           it has put nothing down, whoever has taken its load off it
    it names the task no more, after a time in which it was    nobody knows where it has been: what it might have taken is booked
    not heard                                                  out, what it might have brought is not booked in
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from msgspec.structs import replace

from dray.body import CloseDock
from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Phase
from dray.protocol.contract_net.bookings import Bookings
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life

UNHEARD_S = 8.0
"""No vehicle takes a load away, puts it down elsewhere and ends its task within this; several heartbeats of one that works come."""

HEARD_KEPT = 256
"""Vehicles of which it is known when they were heard last: more than any dock has to do with at a time."""

_MAY_BE_INSIDE = frozenset({Phase.LOADING, Phase.UNLOADING, Phase.RETURNING})


class Departures:
    """Of one dock.

    Args:
        node: where vehicles stand at it.
        subscriptions: whose heartbeats are heard.
        bookings: what its body is told.
        left: called with a vehicle that has left, and the task for which it was watched; empty where nobody knows for which.
    """

    def __init__(
        self,
        node: str,
        subscriptions: HeartbeatSubscriptions,
        bookings: Bookings,
        life: Life,
        left: Callable[[str, str], None] = lambda _vehicle, _task: None,
    ) -> None:
        self._node, self._subscriptions, self._life = node, subscriptions, life
        self._bookings, self._left = bookings, left
        self._leaving: dict[str, DepartureMemory] = {}
        """By vehicle, what it may have moved."""
        self._newest: BoundedMap[str, tuple[int, int]] = BoundedMap(HEARD_KEPT)
        """By vehicle, incarnation and number of its newest heartbeat."""
        self._at_task: BoundedMap[str, tuple[str, int, float]] = BoundedMap(HEARD_KEPT)
        """By vehicle, the task and the epoch that it has named last, and when."""

    def watch(self, load: DepartureMemory) -> None:
        """A vehicle is not wanted any more, and may be inside. Harmless when that is known."""
        if load.vehicle not in self._leaving:
            self._subscriptions.follow(load.vehicle)
            self._leaving[load.vehicle] = load
            self._life.commit()

    def take_back(self, load: DepartureMemory, now_s: float) -> None:
        """A vehicle that has its load on board stands here to put it down, once it is let in (`note_let_in`).

        Harmless when that is known; of what it was watched for before nothing was put down.
        """
        known = self._leaving.get(load.vehicle)
        load = replace(load, let_in=False, returns=True)
        if known is not None and replace(known, let_in=False) != load:
            if known.item == load.item and known.change < 0:
                self._bookings.say(known)
            self._leaving[load.vehicle] = load
            self._life.commit()
        self._at_task[load.vehicle] = (load.task, load.epoch, now_s)
        self.watch(load)

    def waits_for(self, vehicle: str) -> bool:
        """Whether a vehicle may still be inside, and the dock is shut once it has left."""
        return vehicle in self._leaving

    def note_let_in(self, vehicle: str, task: str, epoch: int) -> None:
        """The dock was opened for a vehicle: it may put down what it has brought back. Harmless when it was not watched for that."""
        load = self._leaving.get(vehicle)
        if load is not None and (load.task, load.epoch) == (task, epoch) and not load.let_in:
            self._leaving[vehicle] = replace(load, let_in=True)
            self._life.commit()

    def note_done(self, vehicle: str, now_s: float, *, aboard: bool) -> None:
        """A vehicle stands here for something else, and is done with what it was watched for. Harmless when it was not watched.

        Args:
            vehicle: which.
            now_s: the present time.
            aboard: whether it has a load on board.
        """
        if (load := self._leaving.get(vehicle)) is not None:
            self._end(load, aboard=aboard or not self._was_heard(load, now_s))

    def on_put_down(self, vehicle: str, task: str, epoch: int, quantity: int) -> None:
        """A vehicle says that its load is down, so many pieces of it. Harmless when it was not watched for them.

        Its own word counts though it was not heard for a while: nobody says this of a load that lies elsewhere.
        """
        load = self._leaving.get(vehicle)
        if load is not None and (load.task, load.epoch) == (task, epoch) and load.change > 0:
            # No vehicle brings more than it was given.
            self._end(replace(load, change=min(load.change, quantity)), aboard=False)

    def on_vehicle(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """A vehicle tells where it is, and what it does."""
        said = (heartbeat.incarnation, heartbeat.seq)
        if said <= self._newest.get(heartbeat.atv, (-1, 0)):
            return
        self._newest[heartbeat.atv] = said
        load, carries = self._leaving.get(heartbeat.atv), heartbeat.task
        if load is not None:
            names = carries is not None and (
                not load.task or (carries.task, carries.epoch) == (load.task, load.epoch)
            )
            phase = carries.phase if carries is not None and names else None
            if heartbeat.node != self._node or phase not in _MAY_BE_INSIDE:
                has_it = heartbeat.load == load.item and heartbeat.load_quantity > 0
                aboard = has_it or phase is Phase.RETURNING if names else not self._was_heard(load, now_s)
                self._end(load, aboard=aboard)
        if carries is not None:
            self._at_task[heartbeat.atv] = (carries.task, carries.epoch, now_s)

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

    def _was_heard(self, load: DepartureMemory, now_s: float) -> bool:
        """Whether a vehicle has named the task until now."""
        task, epoch, at_s = self._at_task.get(load.vehicle, ("", 0, -NEVER_S))
        return (task, epoch) == (load.task, load.epoch) and now_s - at_s < UNHEARD_S

    def _end(self, load: DepartureMemory, *, aboard: bool) -> None:
        """A vehicle has left; `aboard`: with its load, or nobody knows."""
        if load.let_in and load.change and aboard is (load.change < 0):
            self._bookings.say(load)
        self._close(load.vehicle)

    def _close(self, vehicle: str) -> None:
        load = self._leaving.pop(vehicle)
        self._subscriptions.unfollow(vehicle)
        self._life.instruct(CloseDock(vehicle=vehicle))
        self._left(vehicle, load.task)
        self._life.commit()
