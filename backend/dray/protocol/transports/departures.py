"""Vehicles that may still be at a dock after their transport ended there: the dock stays open until each has left.

A transport is cancelled or taken over while its vehicle loads or unloads. A dock that makes itself safe
(`Visits.answers`) must then stay locked: the vehicle's forks may be inside. The vehicle's heartbeat tells when it is
done. It is inside while it stands at the dock's node and loads, unloads, or has just been told to return its load.
A silent vehicle is assumed to be inside; one that people carried away is not.

Its load is booked by what the heartbeats show, whichever carrier has the transport by then. A body that does not
count is told of it (`Book`).

    it names the task, brings back or has its load on board    it has taken it, or not put it down
    it names the task, without                                 it has put it down, or not taken it
    it names the task no more, and was heard at it until then  the same: no vehicle ends a task with its load on board
    it stands here and names no task at all                    as if it named this one: it has lost its memory, and no
                                                               vehicle comes to a dock without a task
    the same in a later life, and it came to load              its body may go on loading: what it leaves with counts
    it has lost its memory here, and left with nothing on      the same, whatever it was heard doing since (`left_empty`)
    board
    it brings the same item back for another task              it has lost its memory, and found the load on board
    it does so here, and is without it a moment later          its body has put it down: it had still unloaded
    it has brought its load back, and was not let in           it has put nothing down, even if its load is off it
    it names another task, or stands elsewhere, after a time   where it has been is unknown: a load to take is booked out,
    in which it was not heard                                  a load to bring is booked in once it reports that it is down
    an earlier life let it in to bring a load, and no notes    the load is booked in once it reports as down what it brought
    say for which task                                         for a task that is unknown
    an earlier life let it in to bring a load, and it has      the same; until then a person is asked whether the load is
    forgotten its task, without such a load on board           there (`held`)
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from dray.body import CloseDock
from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Phase
from dray.messages.overtaken import LatestNumbers
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.visits import Visits

UNHEARD_S = 8.0
"""Too short for a vehicle to unload elsewhere and end its task; long enough for several heartbeats."""

HEARD_KEPT = 256
"""Vehicles whose last heartbeat time is kept: more than any dock serves at a time."""

GONE_KEPT = 64
"""Loads of vehicles that have left, of which each may still report that it is down."""

_MAY_BE_INSIDE = frozenset({Phase.LOADING, Phase.UNLOADING, Phase.RETURNING})


class Departures:
    """The departures of one dock.

    Args:
        node: where vehicles stand at it.
        visits: the vehicles at it.
        subscriptions: for following vehicles' heartbeats.
        bookings: reports to its body.
    """

    def __init__(
        self,
        node: str,
        visits: Visits,
        subscriptions: HeartbeatSubscriptions,
        bookings: Bookings,
        life: Life,
    ) -> None:
        self._node, self._visits = node, visits
        self._subscriptions, self._bookings, self._life = subscriptions, bookings, life
        self._leaving: dict[str, DepartureMemory] = {}
        """By vehicle: the load that it may have moved."""
        self._gone: BoundedMap[tuple[str, str, int], DepartureMemory] = BoundedMap(GONE_KEPT)
        """Loads that were not booked in when their vehicle left, by vehicle, task and epoch."""
        self._newest: LatestNumbers[str] = LatestNumbers(HEARD_KEPT)
        """By vehicle: its newest heartbeat, by incarnation and number."""
        self._at_task: BoundedMap[str, tuple[str, int, float]] = BoundedMap(HEARD_KEPT)
        """By vehicle: the task and epoch of its last heartbeat, and when it came; of the watched task while it brings back
        that load, or may still take it, and has not driven off yet."""
        self._named_in: BoundedMap[str, int] = BoundedMap(HEARD_KEPT)
        """By vehicle: its last life that has named a task."""

    def watch(self, load: DepartureMemory) -> None:
        """Follow a vehicle that may be inside until it leaves. Repeating this is harmless."""
        if load.vehicle not in self._leaving:
            self._subscriptions.follow(load.vehicle)
            self._leaving[load.vehicle] = load
            self._life.commit()

    def take_back(self, load: DepartureMemory, now_s: float) -> None:
        """Watch a vehicle that returns its load here, once it is let in (`note_let_in`).

        Repeating this is harmless. What it was watched for before was not put down.
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

    def loads(self) -> tuple[DepartureMemory, ...]:
        """What the watched vehicles may put down or take."""
        return tuple(self._leaving.values())

    def waits_for(self, vehicle: str) -> bool:
        """Whether a vehicle may still be inside; the dock is shut once it has left."""
        return vehicle in self._leaving

    def is_unnoted(self, vehicle: str, node: str) -> bool:
        """Whether a vehicle at a node may have been let in here by an earlier life, of whose load no notes tell."""
        load = self._leaving.get(vehicle)
        return load is not None and not load.task and node == self._node

    def note_let_in(self, vehicle: str, task: str, epoch: int) -> None:
        """The dock was opened for a vehicle, which may put down its returned load. Others are ignored."""
        load = self._leaving.get(vehicle)
        if load is not None and (load.task, load.epoch) == (task, epoch) and not load.let_in:
            self._leaving[vehicle] = replace(load, let_in=True)
            self._life.commit()

    def note_done(self, vehicle: str, now_s: float, *, aboard: bool) -> bool:
        """A vehicle that stands here for another task has done what it was watched for. Ignored if not watched.

        Args:
            vehicle: its id.
            now_s: the present time.
            aboard: whether it has a load on board.

        Returns:
            Whether it is unknown what it was let in for: perhaps for this task, and then its body may still load.
        """
        if (load := self._leaving.get(vehicle)) is None:
            return False
        self._end(load, aboard=aboard or not self._was_heard(load, now_s))
        return not load.task

    def on_put_down(self, vehicle: str, task: str, epoch: int, quantity: int) -> bool:
        """A vehicle reports `quantity` pieces as put down. Ignored if it was not watched for them.

        Its report counts even after silence: no vehicle reports this of a load that lies elsewhere.

        Returns:
            Whether it must report again: it is here for another load, and a body shuts its dock when it books.
        """
        load, gone = self._leaving.get(vehicle), self._gone.get((vehicle, task, epoch))
        if load is not None and (load.task, load.epoch) == (task, epoch) and load.change > 0:
            # A vehicle brings at most what it was given.
            self._end(_reported(replace(load, change=min(load.change, quantity))), aboard=False)
        elif gone is not None:
            if load is not None or self._visits.is_here(vehicle):
                return True
            del self._gone[vehicle, task, epoch]
            self._bookings.say(replace(gone, change=min(gone.change, quantity)))
        return False

    def forget(self, load: DepartureMemory) -> None:
        """A person has seen the load of a vehicle that has left: its report would tell nothing new."""
        if self._gone.pop((load.vehicle, load.task, load.epoch), None) is not None:
            self._life.commit()

    def expect_unnoted(self, vehicle: str, item: str, quantity: int) -> None:
        """An earlier life, of which no notes are left, let a vehicle in to bring a load: only its own report tells the task."""
        self._gone[vehicle, "", 0] = DepartureMemory(vehicle, "", 0, item, quantity)
        self._life.commit()

    def name_unnoted(self, vehicle: str, task: str, epoch: int) -> None:
        """A vehicle reports the load of an unknown task as put down: an earlier life let it in for this. Ignored for others."""
        if (load := self._gone.pop((vehicle, "", 0), None)) is not None:
            self._gone[vehicle, task, epoch] = replace(load, task=task, epoch=epoch)
            self._life.commit()

    def note_brought(self, vehicle: str) -> None:
        """What a vehicle has brought is booked in: it has nothing else to report of an earlier life, and needs no more room."""
        load = self._leaving.get(vehicle)
        if load is not None and load.counted:
            self._leaving[vehicle] = replace(load, counted=0)
            self._life.commit()
        if self._gone.pop((vehicle, "", 0), None) is not None:
            self._life.commit()

    def on_vehicle(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Handle a vehicle's heartbeat."""
        if not self._newest.takes(heartbeat.atv, (heartbeat.incarnation, heartbeat.seq), now_s):
            return
        load, carries = self._leaving.get(heartbeat.atv), heartbeat.task
        moves_it = False
        if load is not None:
            names = carries is not None and (
                not load.task or (carries.task, carries.epoch) == (load.task, load.epoch)
            )
            phase = carries.phase if carries is not None and names else None
            has_it = heartbeat.load == load.item and heartbeat.load_quantity > 0
            found_it = has_it and not names and carries is not None and carries.phase is Phase.RETURNING
            never_left = carries is None and heartbeat.node == self._node
            may_load = (
                never_left
                and not has_it
                and load.change < 0
                and self._named_in.get(heartbeat.atv) != heartbeat.incarnation
            )
            moves_it = may_load or (found_it and load.change > 0 and heartbeat.node == self._node)
            if heartbeat.node != self._node or not (found_it or may_load or phase in _MAY_BE_INSIDE):
                left_empty = heartbeat.left_empty == self._node
                is_known = names or never_left or left_empty or found_it
                if phase is Phase.HANDING_OVER and load.change > 0:
                    load = _reported(load)
                brings = (has_it or phase is Phase.RETURNING) and not left_empty
                self._end(load, aboard=brings if is_known else not self._was_heard(load, now_s))
        if carries is not None:
            self._named_in[heartbeat.atv] = heartbeat.incarnation
        if (named := load if moves_it else carries) is not None:
            self._at_task[heartbeat.atv] = (named.task, named.epoch, now_s)

    def note_left(self, vehicle: str) -> None:
        """A vehicle has left without the load it was let in for: tell a body that waits for its report."""
        if self._visits.is_report_awaited(vehicle) and vehicle not in self._leaving:
            self._life.instruct(CloseDock(vehicle=vehicle))

    def on_elsewhere(self, vehicle: str, task: str) -> None:
        """A vehicle that was let in by this task, or waits to be, is heard elsewhere: shut the dock.

        If that heartbeat has come late, a later one tells so of a vehicle inside, and one that waits asks again.
        """
        asked, let_in = self._visits.asked.get(vehicle), self._visits.inside.get(vehicle)
        if let_in is not None:
            if self._visits.answers and let_in.task == task:
                self.watch(DepartureMemory(vehicle))
        elif asked is not None and asked[1].task == task:
            self._visits.forget_request(vehicle)
            self._life.instruct(CloseDock(vehicle=vehicle))

    def on_carried_away(self, vehicle: str) -> None:
        """People have carried a vehicle away. What it put down before is unknown, so nothing is booked."""
        if vehicle in self._leaving:
            self._close(vehicle)
        self._visits.inside.pop(vehicle, None)
        self._visits.forget_request(vehicle)

    # --- over a restart ---

    def memories(self) -> tuple[DepartureMemory, ...]:
        """The watched vehicles, for the next life."""
        gone = tuple(replace(load, gone=True) for load in self._gone.values())
        return (*self.loads(), *gone)

    def restore(self, memories: Iterable[DepartureMemory]) -> None:
        """Go on watching the vehicles of an earlier life."""
        for load in memories:
            if load.gone:
                self._gone[load.vehicle, load.task, load.epoch] = replace(load, gone=False)
            else:
                self.watch(load)

    def _was_heard(self, load: DepartureMemory, now_s: float) -> bool:
        """Whether a vehicle has named the task in its recent heartbeats."""
        task, epoch, at_s = self._at_task.get(load.vehicle, ("", 0, -NEVER_S))
        return (task, epoch) == (load.task, load.epoch) and now_s - at_s < UNHEARD_S

    def _end(self, load: DepartureMemory, *, aboard: bool) -> None:
        """A vehicle has left; `aboard`: with its load, or that is unknown."""
        if load.let_in and load.change and aboard is (load.change < 0):
            self._bookings.say(load)
        elif load.change > 0 and not load.returns:
            self._gone[load.vehicle, load.task, load.epoch] = load
        self._close(load.vehicle)

    def _close(self, vehicle: str) -> None:
        load = self._leaving.pop(vehicle)
        self._subscriptions.unfollow(vehicle)
        self._life.instruct(CloseDock(vehicle=vehicle))
        self._visits.note_departed(vehicle, load.task)
        self._life.commit()


def _reported(load: DepartureMemory) -> DepartureMemory:
    """A load that its vehicle reports as put down here: the dock was open for it, if only in an earlier life."""
    return load if load.returns else replace(load, let_in=True)
