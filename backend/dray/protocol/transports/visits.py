"""The visits at one dock (`visit`): each load is booked once, and the dock stays locked while a vehicle may be inside.

A transport is cancelled or taken over while its vehicle loads or unloads. A dock that makes itself safe (`answers`) must then
stay locked: the vehicle's forks may be inside. A silent vehicle is assumed to be inside; one that people carried away is not.
While the contract of this place's own transport stands, that contract is followed (`handovers`); all other visits are followed
by heartbeats. A body that does not count is told what has moved (`Book`).

If it is unknown whether a load has moved, nothing is promised that may not lie there:

    to take     its coordinator is asked until it answers; without an answer that says so, or without anybody to ask, it is
                booked out, in doubt
    to bring    it is owed: booked in once its vehicle reports that it is down

People are asked for either (`doubts`). The question to a coordinator is `StockReserved`. One that needs the pieces no more, or
not for that carrier, answers with `StockFreed`. It says whether it knows that they were fetched, or cannot exclude it.

A life without notes knows from the body whom an earlier one has let in, and what the body has let move. It waits for the word
of that vehicle (`on_word`). A life with notes knows that a vehicle which waits has moved nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from msgspec.structs import replace

from dray.body import CloseDock
from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Docked, StockFreed, StockReserved
from dray.messages.overtaken import LatestNumbers
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.doubts import Doubts
from dray.protocol.transports.visit import Stage, Visit, stage_of

AGAIN_S = 10.0
"""Time after which a silent coordinator is asked again (s)."""

HEARD_KEPT = 256
"""Vehicles whose last heartbeat is kept: more than any dock serves at a time."""

OWED_KEPT = 64
"""Loads of vehicles that have left, of which each may still report that it is down."""


class Request(NamedTuple):
    """A vehicle's request that waits for the dock to open."""

    docked: Docked
    load: DepartureMemory
    """What it may move once the dock is open."""
    since_s: float
    """Since when it is the next one (plant clock, s)."""
    asked_s: float
    """When it last asked (plant clock, s)."""


class Visits:
    """The visits of one dock.

    Args:
        node: where vehicles stand at it.
        subscriptions: for following vehicles' heartbeats.
        bookings: reports to its body.

    Attributes:
        answers: whether the body reports when it has opened (`dray.body.WorkcellState`); otherwise it is open at
            once.
        counts: whether the body counts what vehicles bring and take.
        asked: by vehicle, its request that waits for the dock to open.
        doubts: loads of which nobody can tell, for which people are asked.
    """

    def __init__(
        self, node: str, subscriptions: HeartbeatSubscriptions, bookings: Bookings, life: Life
    ) -> None:
        self._node, self._subscriptions, self._bookings, self._life = node, subscriptions, bookings, life
        self.answers = False
        self.counts = True
        self.asked: dict[str, Request] = {}
        self.doubts = Doubts(life)
        self._visits: dict[str, Visit] = {}
        self._owed: BoundedMap[tuple[str, str, int], DepartureMemory] = BoundedMap(OWED_KEPT)
        """Loads that were not booked in when their vehicle left, by vehicle, task and epoch."""
        self._newest: LatestNumbers[str] = LatestNumbers(HEARD_KEPT)
        """By vehicle: its newest heartbeat, by incarnation and number."""

    # --- what is known of a vehicle ---

    def get(self, vehicle: str) -> Visit | None:
        return self._visits.get(vehicle)

    def is_inside(self, vehicle: str) -> bool:
        """Whether a vehicle was let in, and its permission stands."""
        visit = self._visits.get(vehicle)
        return visit is not None and visit.stage is Stage.INSIDE

    def may_have_brought(self, vehicle: str, item: str) -> bool:
        """Whether the dock was opened for a vehicle with such a load, in this life or, as far as the body remembers, in an earlier one."""
        visit = self._visits.get(vehicle)
        if visit is None:
            owed = self._owed.get((vehicle, "", 0))
            return owed is not None and owed.item == item
        was_let_in = visit.stage is not Stage.WAITS or (visit.brings and visit.is_unnamed)
        return was_let_in and visit.load.item in ("", item)

    def is_here(self, vehicle: str) -> bool:
        """Whether a vehicle waits, or may be inside."""
        visit = self._visits.get(vehicle)
        return vehicle in self.asked or (visit is not None and visit.stage is not Stage.GONE)

    def may_move(self, item: str) -> bool:
        """Whether a vehicle may be moving an item, or has moved it and it is not decided yet: a count tells nothing now."""
        visits = (visit for visit in self._visits.values() if visit.stage is not Stage.WAITS)
        said = any(load.item == item for load in self._bookings.memories())
        return said or any(visit.load.item in ("", item) for visit in visits)

    def waits_for(self, vehicle: str) -> bool:
        """Whether the dock is shut once a vehicle has left: its permission has ended, or is for a load that it brings back."""
        visit = self._visits.get(vehicle)
        may_take = visit is not None and visit.takes and visit.stage in (Stage.WAITS, Stage.INSIDE)
        return visit is not None and visit.is_followed and not may_take

    def loads(self) -> tuple[DepartureMemory, ...]:
        """What the followed vehicles may put down or take."""
        return tuple(visit.load for visit in self._visits.values() if visit.is_followed)

    def is_of_earlier_life(self, vehicle: str) -> bool:
        """Whether an earlier life let a vehicle in, and its permission stands."""
        visit = self._visits.get(vehicle)
        return visit is not None and visit.stage is Stage.INSIDE and visit.is_unnamed

    # --- the dock opens and shuts ---

    def forget_request(self, vehicle: str) -> Request | None:
        """Forget a request. Returns it; None if the vehicle has not asked."""
        return self.asked.pop(vehicle, None)

    def ask(self, request: Request) -> None:
        """A vehicle waits for the dock to open. Repeating this is harmless."""
        vehicle = request.load.vehicle
        self.asked[vehicle] = request
        if vehicle not in self._visits:
            self._put(request.load, Stage.WAITS)
            self._life.commit()

    def let_in(self, load: DepartureMemory) -> None:
        """The dock was opened for a vehicle."""
        visit = self._visits.get(load.vehicle)
        if visit is None or not visit.is_of(load):
            visit = self._put(load, Stage.INSIDE)
        elif not visit.is_followed:
            visit.load = load
        visit.stage = Stage.INSIDE
        if visit.is_followed or self.answers:
            self._life.commit()

    def expect(self, load: DepartureMemory, now_s: float) -> None:
        """A vehicle stands here to take a load for another place. Repeating this is harmless."""
        if self.counts and not self.answers:
            return
        visit = self._visits.get(load.vehicle)
        if visit is None or not visit.is_of(load):
            visit = self._put(load, Stage.WAITS)
        visit.load = load
        visit.stage = visit.stage.renewed
        visit.heard_s, visit.asked_s = now_s, -NEVER_S
        self._follow(visit)

    def take_back(self, load: DepartureMemory, now_s: float) -> None:
        """Watch a vehicle that returns its load here, once it is let in. Repeating this is harmless.

        What it was watched for before was not put down.
        """
        load = replace(load, returns=True)
        visit = self._visits.get(load.vehicle)
        if visit is None or visit.load != load:
            visit = self._put(load, Stage.WAITS)
        visit.heard_s = now_s
        self._follow(visit)

    def withdraw(self, visit: Visit, load: DepartureMemory | None) -> None:
        """The permission of a vehicle that was let in has ended: wait for it to leave.

        Args:
            visit: its visit.
            load: what it may move meanwhile and nobody else would book; None for nothing.
        """
        if not self.answers:
            # No moving dock can hurt the vehicle: close at once, and wait only for its load.
            self._close(visit.load.vehicle)
            if self.counts:
                self._forget(visit.load.vehicle)
                return
        was_unnamed = visit.is_unnamed
        if not visit.is_followed:
            is_it = load is not None and (was_unnamed or visit.is_of(load))
            visit.load = load if load is not None and is_it else DepartureMemory(visit.load.vehicle)
        # Whether an earlier life let it in for this load to bring is unknown: book that in only on its own word.
        visit.stage = Stage.WAITS if was_unnamed and visit.brings else Stage.LEAVING
        self._follow(visit)

    def note_done(self, vehicle: str, task: str) -> None:
        """A vehicle has done what it was let in for by a task; it is outside. Ignored if it was let in for another one."""
        visit = self._visits.get(vehicle)
        if visit is None or visit.stage is not Stage.INSIDE or visit.load.task not in ("", task):
            return
        if visit.is_followed:
            visit.stage, visit.load = Stage.LEAVING, replace(visit.load, change=0)
            self._life.commit()
        else:
            self._forget(vehicle)

    def dismiss(self, vehicle: str) -> None:
        """Nothing is expected of a vehicle any more: forget it, and tell a body that waits for its report."""
        self._forget(vehicle)
        self._close(vehicle)

    # --- reports ---

    def on_docked(self, vehicle: str, docked: Docked, now_s: float, *, unloads: bool) -> None:
        """A vehicle stands here, perhaps for another load than before, with which it is done.

        Called before the dock is opened for it: a body shuts its dock when it books.
        """
        visit = self._visits.get(vehicle)
        change = docked.quantity if unloads else -docked.quantity
        asked = DepartureMemory(vehicle, docked.task, docked.epoch, docked.item, change)
        if visit is None or not visit.is_followed or visit.is_of(asked):
            return
        was_heard = visit.was_heard(now_s)
        if visit.may_be_for(docked, unloads=unloads):
            self._name(visit, asked, now_s)
            return
        if was_heard and visit.is_unnamed and not visit.takes:
            visit.note_down()
        moved = visit.has_moved_before(docked, unloads=unloads, was_heard=was_heard)
        self._end(visit, moved=moved, docks=visit.takes)

    def on_put_down(self, vehicle: str, task: str, epoch: int, quantity: int, *, known: bool = True) -> bool:
        """A vehicle reports `quantity` pieces as put down. Ignored if it was not watched for them.

        Its report counts even after silence: no vehicle reports this of a load that lies elsewhere. A task that is
        not `known` is one for which an earlier life without notes may have let it in.

        Returns:
            Whether it must report again: it is here for another load, and a body shuts its dock when it books.
        """
        visit = self._visits.get(vehicle)
        if visit is not None and visit.is_followed and visit.brings:
            if visit.is_for(task, epoch):
                visit.note_down()
                # A vehicle brings at most what it was given.
                visit.load = replace(visit.load, change=min(visit.load.change, quantity))
                self._end(visit, moved=True)
                return False
            if not known and visit.is_unnamed:
                return True
        key = (vehicle, task, epoch)
        if not known and (vehicle, "", 0) in self._owed:
            key = (vehicle, "", 0)
        if (owed := self._owed.get(key)) is None:
            return False
        if self.is_here(vehicle):
            return True
        self.forget_owed(*key)
        self._bookings.say(replace(owed, task=task, epoch=epoch, change=min(owed.change, quantity)))
        return False

    def note_brought(self, vehicle: str) -> None:
        """What a vehicle has brought is in the books: it needs no more room, and there is nothing else to report."""
        visit = self._visits.get(vehicle)
        if visit is not None and visit.brings and (self.counts or visit.is_unnamed):
            visit.load = replace(visit.load, change=0)
            self._life.commit()
        self.forget_owed(vehicle)

    def forget_owed(self, vehicle: str, task: str = "", epoch: int = 0) -> None:
        """A load is in the books, or a person has seen it: the report of its vehicle would tell nothing new.

        Without a task it is the load for which a life without notes has let the vehicle in.
        """
        if (owed := self._owed.pop((vehicle, task, epoch), None)) is not None:
            self.doubts.on_told(owed)
            self._life.commit()

    def on_freed(self, sender: str, freed: StockFreed) -> bool:
        """A coordinator frees pieces, and tells whether they were fetched. Returns whether they were booked out."""
        for visit in list(self._visits.values()):
            is_it = (visit.load.task, visit.load.coordinator) == (freed.task, sender)
            is_it &= freed.epoch in (0, visit.load.epoch)
            if is_it and visit.asked_s > -NEVER_S:
                moved = True if freed.known else None
                self._end(visit, moved=moved if freed.fetched else False)
                return freed.fetched
        return False

    def on_vehicle(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Handle a vehicle's heartbeat: it may have left."""
        if not self._newest.takes(heartbeat.atv, (heartbeat.incarnation, heartbeat.seq), now_s):
            return
        if (visit := self._visits.get(heartbeat.atv)) is None:
            return
        seen = visit.see(heartbeat, self._node, now_s)
        if not visit.is_followed:
            return
        if visit.takes and (seen.names_task or visit.stage is Stage.WAITS):
            self._mark(visit, ended=not seen.names_task)
        if visit.is_here_still(seen):
            visit.heard_s = now_s
            return
        if visit.is_told_down(seen):
            visit.note_down()
        moved = visit.has_moved(seen)
        if moved is None and visit.load.coordinator and not self.counts:
            self._ask(visit, now_s, is_here=seen.is_here)
        else:
            self._end(visit, moved=moved)

    def on_word(self, load: DepartureMemory, node: str) -> None:
        """A vehicle says at a node what it moves: taken for the load for which an earlier life without notes let it in here.

        What the body remembers as a load to take keeps the name under which it is booked. Of what the body remembers as
        a load to bring, the vehicle brings no other item and no more pieces.
        """
        visit = self._visits.get(load.vehicle)
        if visit is None or not visit.is_followed or visit.takes or not visit.is_unnamed:
            return
        remembered = visit.load
        if remembered.change and (load.change < 0 or load.item != remembered.item):
            return
        if node == self._node and not self.counts:
            change = min(load.change, remembered.change) if remembered.change else load.change
            visit.load, visit.stage = replace(load, change=change), Stage.LEAVING
            self._life.commit()

    def on_carried_away(self, vehicle: str) -> None:
        """People have carried a vehicle away. What it put down before is unknown, so nothing is booked."""
        visit = self._visits.get(vehicle)
        self.forget_request(vehicle)
        if self.waits_for(vehicle):
            self._close(vehicle)
        if visit is not None and visit.load.coordinator:
            visit.stage = Stage.GONE
            self._life.commit()
        else:
            self._forget(vehicle)

    # --- over a restart ---

    def memories(self) -> tuple[DepartureMemory, ...]:
        """The followed visits, the vehicles that wait, and the owed loads, for the next life."""
        noted = tuple(visit.memory() for visit in self._visits.values() if visit.is_noted)
        return (*noted, *(replace(load, gone=True) for load in self._owed.values()))

    def restore(self, memories: Iterable[DepartureMemory]) -> None:
        """Go on with the visits of an earlier life, after `restore_opened`."""
        for memory in memories:
            if memory.only_waits:
                if (visit := self._visits.get(memory.vehicle)) is not None:
                    visit.load, visit.stage = memory, Stage.WAITS
                continue
            load = replace(memory, gone=False, permitted=False, let_in=True)
            if memory.gone and memory.brings:
                self._owed[memory.vehicle, memory.task, memory.epoch] = load
                continue
            self._follow(self._put(load, stage_of(memory)))

    def restore_opened(self, opened: Iterable[str]) -> None:
        """Continue with the vehicles that an earlier life let in, as far as the body remembers."""
        if self.answers or not self.counts:
            for vehicle in opened:
                self._put(DepartureMemory(vehicle), Stage.INSIDE)

    # --- what is not known yet ---

    def _name(self, visit: Visit, load: DepartureMemory, now_s: float) -> None:
        """A vehicle that an earlier life let in, for what no notes say, asks for a load: it may be loading that."""
        before = visit.load
        named = self._put(
            replace(load, item=load.item or before.item, change=before.change or load.change), Stage.INSIDE
        )
        named.heard_s = now_s
        if named.load.change:
            self._follow(named)

    def _ask(self, visit: Visit, now_s: float, *, is_here: bool) -> None:
        """Ask a coordinator whether a vehicle has taken its load: it was not heard for a while."""
        load = visit.load
        if not is_here and visit.stage is not Stage.GONE:
            if self.answers or visit.stage is Stage.INSIDE:
                self._close(load.vehicle)
            visit.stage = Stage.GONE
            self._life.commit()
        if now_s - visit.asked_s >= AGAIN_S:
            visit.asked_s = now_s
            self._life.send(load.coordinator, StockReserved(load.task, load.epoch, load.item, load.quantity))

    def _mark(self, visit: Visit, *, ended: bool) -> None:
        """Note whether a vehicle names its task no more, over a restart too."""
        if visit.load.ended is not ended:
            visit.load = replace(visit.load, ended=ended)
            self._life.commit()

    # --- the end of a visit ---

    def _end(self, visit: Visit, *, moved: bool | None, docks: bool = False) -> None:
        """A vehicle has left.

        Args:
            visit: its visit.
            moved: whether its load has moved; None if nobody can tell.
            docks: whether it asks here for another load.
        """
        vehicle, task = visit.load.vehicle, visit.load.task
        is_booked = self._book(visit, moved)
        may_still_load = visit.takes and visit.stage is Stage.INSIDE and not is_booked
        self._forget(vehicle)
        if vehicle in self.asked and self.asked[vehicle].load.task == task:
            self.forget_request(vehicle)
        if docks and (is_booked or may_still_load):
            return  # A body shuts its dock when it books, and opens it anew.
        if may_still_load and not self.answers:
            # No moving dock can hurt it: it may come back as long as it has a permission.
            self._put(DepartureMemory(vehicle, task, visit.load.epoch), Stage.INSIDE)
        else:
            self._close(vehicle)

    def _book(self, visit: Visit, moved: bool | None) -> bool:
        """Book a load, or owe it, and note a doubt. Returns whether it counts as moved: in doubt a load to take does."""
        load, was_let_in = visit.load, visit.stage is not Stage.WAITS
        has_moved = was_let_in and (visit.takes if moved is None else moved)
        if self.counts or not load.change:
            is_in_doubt = False  # Nothing is to be booked.
        elif has_moved:
            is_in_doubt = moved is None
            if not (load.task or load.epoch):
                load = replace(load, epoch=self._life.incarnation)  # A body books each load of one name once.
            self._bookings.say(load)
        elif load.brings and not load.returns:
            is_in_doubt = moved is None or (moved and bool(load.task))
            self._owed[load.vehicle, load.task, load.epoch] = load
        else:
            is_in_doubt = moved is None and was_let_in
        if is_in_doubt:
            self.doubts.note(load)
        elif has_moved:
            self.doubts.on_told(load)
        return has_moved

    def _put(self, load: DepartureMemory, stage: Stage) -> Visit:
        """Begin a visit in the place of another one."""
        self._forget(load.vehicle)
        visit = self._visits[load.vehicle] = Visit(load, stage)
        return visit

    def _follow(self, visit: Visit) -> None:
        if not visit.is_followed:
            visit.is_followed = True
            self._subscriptions.follow(visit.load.vehicle)
        self._life.commit()

    def _forget(self, vehicle: str) -> None:
        visit = self._visits.pop(vehicle, None)
        if visit is not None and visit.is_followed:
            self._subscriptions.unfollow(vehicle)
        if visit is not None and visit.is_noted:
            self._life.commit()

    def _close(self, vehicle: str) -> None:
        self._life.instruct(CloseDock(vehicle=vehicle))
