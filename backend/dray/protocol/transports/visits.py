"""Vehicles at one dock, each from its request until it has left and its load is decided.

    WAITS --the dock opens--> INSIDE --its permission ends--> LEAVING --it has left--> over: its load has moved, or not
      |                         |                               |
      +-------------------------+--it was heard elsewhere-------+--> GONE: whether it has taken its load is asked

A transport is cancelled or taken over while its vehicle loads or unloads. A dock that makes itself safe (`answers`)
must then stay locked: the vehicle's forks may be inside. A silent vehicle is assumed to be inside; one that people
carried away is not. While the contract of this place's own transport stands, that contract is followed (`handovers`);
all other visits are followed by heartbeats. A body that does not count is told what has moved (`Book`).

It has left unless it stands at the dock's node, and

    names the task and loads, unloads or returns its load      it is inside
    returns such a load for another task                       it has lost its memory, and found the load on board
    is to take a load, and does not name the task in a life    its body may go on loading, although its agent was started
    that never did, without or shortly after a silence         again without notes: what it leaves with counts

What it has moved when it has left:

    it names the task, or has no task and stands here          a load to take, if it is on board; a load to bring, if not
    it returns such a load for another task                    the same: it has taken it, or put nothing down
    it lost its memory here, and left with nothing on board    a load to bring, whatever it was heard doing since (`left_empty`),
                                                               also one for which an earlier life without notes let it in
    it was heard at the task until now (`UNHEARD_S`)           a load to bring: no vehicle ends a task with its load on board
    the dock was not opened for it                             nothing
    else it is unknown                                         a load to take is booked out if such a load is on board; else its
                                                               coordinator is asked until it answers, and in doubt it is booked
                                                               out: nothing is promised that may not lie there. A load to bring
                                                               is booked in once the vehicle reports that it is down. People are
                                                               asked for either (`doubts`)
    it was heard elsewhere without it, and is asked about      what it has on board later is not from here, unless it names
                                                               the task
    an earlier life let it in, and no notes say for what       what it says here that it carries or hands over, else what the body
                                                               remembers, as unknown. While it stands here without a task and
                                                               a load, its word is waited for; if it comes for another load
                                                               then, what it was to bring is down
    the notes say that it waits                                nothing: no earlier life has let it in

The question is `StockReserved`. A coordinator that needs the pieces no more, or not for that carrier, answers with
`StockFreed`. It says whether it knows that they were fetched, or cannot exclude it.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from msgspec.structs import replace

from dray.body import CloseDock
from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Docked, Phase, StockFreed, StockReserved
from dray.messages.heartbeat import GOODS_ABOARD
from dray.messages.overtaken import LatestNumbers
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.doubts import Doubts

UNHEARD_S = 8.0
"""Too short for a vehicle to unload elsewhere and end its task; long enough for several heartbeats."""

AGAIN_S = 10.0
"""Time after which a silent coordinator is asked again (s)."""

HEARD_KEPT = 256
"""Vehicles whose last heartbeat is kept: more than any dock serves at a time."""

OWED_KEPT = 64
"""Loads of vehicles that have left, of which each may still report that it is down."""

_MAY_BE_INSIDE = frozenset({Phase.LOADING, Phase.UNLOADING, Phase.RETURNING})


class Stage(StrEnum):
    """The stage of a visit."""

    WAITS = "waits"
    """The dock was not opened for it, as far as is known."""
    INSIDE = "inside"
    """It was let in, and its permission stands."""
    LEAVING = "leaving"
    """Its permission has ended, and it may still be inside."""
    GONE = "gone"
    """It was heard elsewhere, and its coordinator is asked for its load."""


class Visit:
    """One vehicle at the dock.

    Attributes:
        load: what it may move; without a task if an earlier life let it in, and no notes say for what.
        stage: its stage.
        is_followed: whether its heartbeats are followed; otherwise a contract of this place tells what it does.
        heard_s: when it was last heard or seen at its task in this life (plant clock, s).
        asked_s: when its coordinator was last asked whether it has fetched the load (plant clock, s).
        named_in: the vehicle's last life that has named its task; 0 for none.
    """

    __slots__ = ("asked_s", "heard_s", "is_followed", "load", "named_in", "stage")

    def __init__(self, load: DepartureMemory, stage: Stage) -> None:
        self.load, self.stage = load, stage
        self.is_followed = False
        self.heard_s = self.asked_s = -NEVER_S
        self.named_in = 0

    @property
    def takes(self) -> bool:
        """Whether it may take a load; otherwise it may bring one, or nothing is to be booked."""
        return self.load.change < 0

    @property
    def is_noted(self) -> bool:
        """Whether the next life must know of it. A body may remember for whom it opens the dock, and not who was let in."""
        return self.is_followed or self.stage is Stage.WAITS

    def is_of(self, load: DepartureMemory) -> bool:
        """Whether it is a visit for this load, in this direction."""
        is_it = (self.load.task, self.load.epoch) == (load.task, load.epoch)
        return is_it and self.load.change * load.change >= 0

    def is_named(self, heartbeat: AtvHeartbeat) -> bool:
        """Whether a heartbeat names its task."""
        task = heartbeat.task
        return task is not None and (task.task, task.epoch) == (self.load.task, self.load.epoch)

    def memory(self) -> DepartureMemory:
        """The record for the next life."""
        if not self.is_followed:
            return DepartureMemory(self.load.vehicle, self.load.task, self.load.epoch, let_in=False)
        return replace(
            self.load,
            let_in=self.stage is not Stage.WAITS,
            permitted=self.stage is Stage.INSIDE,
            gone=self.stage is Stage.GONE,
        )


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
        was_let_in = visit.stage is not Stage.WAITS or (visit.load.change > 0 and not visit.load.task)
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
        """Whether the dock is shut once a vehicle has left, whose permission has ended or is for a returned load."""
        visit = self._visits.get(vehicle)
        may_take = visit is not None and visit.takes and visit.stage in (Stage.WAITS, Stage.INSIDE)
        return visit is not None and visit.is_followed and not may_take

    def loads(self) -> tuple[DepartureMemory, ...]:
        """What the followed vehicles may put down or take."""
        return tuple(visit.load for visit in self._visits.values() if visit.is_followed)

    def is_of_earlier_life(self, vehicle: str) -> bool:
        """Whether an earlier life let a vehicle in, and its permission stands."""
        visit = self._visits.get(vehicle)
        return visit is not None and visit.stage is Stage.INSIDE and not visit.load.task

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
        visit.stage = {Stage.LEAVING: Stage.INSIDE, Stage.GONE: Stage.WAITS}.get(visit.stage, visit.stage)
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
        is_unnoted = not visit.load.task
        if not visit.is_followed:
            is_it = load is not None and (is_unnoted or visit.is_of(load))
            visit.load = load if load is not None and is_it else DepartureMemory(visit.load.vehicle)
        # Whether it was let in for a load to bring is unknown then: book that in only on its own word.
        visit.stage = Stage.WAITS if is_unnoted and visit.load.change > 0 else Stage.LEAVING
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
        load, was_heard = visit.load, self._was_heard(visit, now_s)
        is_same = not docked.item or load.item in ("", docked.item)
        if not load.task and load.change <= 0 and is_same and not unloads:
            # It may still load for what it was let in for.
            load = replace(asked, item=docked.item or load.item, change=load.change or asked.change)
            named = self._put(load, Stage.INSIDE)
            named.heard_s = now_s
            if load.change:
                self._follow(named)
        elif visit.takes:
            has_it = unloads and docked.item == load.item
            self._end(visit, moved=True if has_it else False if was_heard or load.ended else None, docks=True)
        else:
            if was_heard and not load.task:
                self._believe(visit)
            self._end(visit, moved=False if unloads else was_heard or None)

    def on_put_down(self, vehicle: str, task: str, epoch: int, quantity: int, *, known: bool = True) -> bool:
        """A vehicle reports `quantity` pieces as put down. Ignored if it was not watched for them.

        Its report counts even after silence: no vehicle reports this of a load that lies elsewhere. A task that is
        not `known` is one for which an earlier life without notes may have let it in.

        Returns:
            Whether it must report again: it is here for another load, and a body shuts its dock when it books.
        """
        visit = self._visits.get(vehicle)
        if visit is not None and visit.is_followed and visit.load.change > 0:
            if (visit.load.task, visit.load.epoch) == (task, epoch):
                self._believe(visit)
                # A vehicle brings at most what it was given.
                visit.load = replace(visit.load, change=min(visit.load.change, quantity))
                self._end(visit, moved=True)
                return False
            if not known and not visit.load.task:
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
        if visit is not None and visit.load.change > 0 and (self.counts or not visit.load.task):
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
                self._end(visit, moved=freed.fetched and (freed.known or None))
                return freed.fetched
        return False

    def on_vehicle(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Handle a vehicle's heartbeat: it may have left."""
        if not self._newest.takes(heartbeat.atv, (heartbeat.incarnation, heartbeat.seq), now_s):
            return
        if (visit := self._visits.get(heartbeat.atv)) is None:
            return
        names = visit.is_named(heartbeat)
        if names:
            visit.heard_s, visit.named_in = now_s, heartbeat.incarnation
        if not visit.is_followed:
            return
        if visit.takes and (names or visit.stage is Stage.WAITS):
            self._mark(visit, ended=not names)
        was_heard = self._was_heard(visit, now_s)
        if self._is_here_still(visit, heartbeat, was_heard=was_heard):
            visit.heard_s = now_s
        elif (moved := self._has_moved(visit, heartbeat, was_heard=was_heard)) is not None:
            self._end(visit, moved=moved)
        elif visit.load.coordinator and not self.counts:
            self._ask(visit, now_s, is_here=heartbeat.node == self._node)
        else:
            self._end(visit, moved=None)

    def on_word(self, load: DepartureMemory, node: str) -> None:
        """A vehicle says at a node what it moves: taken for the load for which an earlier life without notes let it in here.

        What the body remembers as a load to take keeps the name under which it is booked. Of what the body remembers as
        a load to bring, the vehicle brings no other item and no more pieces.
        """
        visit = self._visits.get(load.vehicle)
        if visit is None or not visit.is_followed or visit.load.task or visit.takes:
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
            if memory.gone and memory.change > 0:
                self._owed[memory.vehicle, memory.task, memory.epoch] = load
                continue
            stage = Stage.GONE if memory.gone else Stage.INSIDE if memory.permitted else Stage.LEAVING
            self._follow(self._put(load, stage if memory.let_in else Stage.WAITS))

    def restore_opened(self, opened: Iterable[str]) -> None:
        """Continue with the vehicles that an earlier life let in, as far as the body remembers."""
        if self.answers or not self.counts:
            for vehicle in opened:
                self._put(DepartureMemory(vehicle), Stage.INSIDE)

    # --- what a heartbeat tells ---

    def _is_here_still(self, visit: Visit, heartbeat: AtvHeartbeat, *, was_heard: bool) -> bool:
        """Whether a vehicle has not left yet; one that is heard elsewhere and may load still has not come yet."""
        load, stage, carries = visit.load, visit.stage, heartbeat.task
        takes, names, has_it = visit.takes, visit.is_named(heartbeat), _has(heartbeat, load.item)
        phase = None if carries is None else carries.phase
        if takes and names and stage is not Stage.LEAVING and phase not in GOODS_ABOARD and not has_it:
            return True
        if heartbeat.node != self._node or stage is Stage.GONE:
            return False
        if not load.task and load.change > 0 and carries is None and not heartbeat.load:
            return True  # It may tell of its load yet, or that it has lost its memory here.
        found_it = phase is Phase.RETURNING and has_it
        if found_it or (phase in _MAY_BE_INSIDE and (names or not load.task)):
            return True
        has_ended = visit.named_in == heartbeat.incarnation or (has_it and stage is not Stage.WAITS)
        return takes and not has_ended and (carries is None or was_heard or not load.task or load.ended)

    def _has_moved(self, visit: Visit, heartbeat: AtvHeartbeat, *, was_heard: bool) -> bool | None:
        """Whether a vehicle that has left has moved its load; None where that is unknown."""
        load, names, carries = visit.load, visit.is_named(heartbeat), heartbeat.task
        is_here, has_it = heartbeat.node == self._node, _has(heartbeat, load.item)
        phase, is_gone = None if carries is None else carries.phase, visit.stage is Stage.GONE
        stands = is_here and carries is None and not is_gone
        if heartbeat.left_empty == self._node:
            self._believe(visit)
            return load.change > 0
        if visit.takes and names:
            return has_it or phase in GOODS_ABOARD
        if visit.takes:
            if has_it and not is_gone and (is_here or was_heard or not load.ended):
                return True
            return False if was_heard or load.ended or stands else None
        if names and phase is Phase.HANDING_OVER:
            self._believe(visit)
        names |= not load.task and carries is not None
        if names or stands or (has_it and phase is Phase.RETURNING):
            return not (has_it or (names and phase is Phase.RETURNING))
        return was_heard or None

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
            self._life.send(load.coordinator, StockReserved(load.task, load.epoch, load.item, -load.change))

    def _was_heard(self, visit: Visit, now_s: float) -> bool:
        """Whether a vehicle was recently heard at its task."""
        return now_s - visit.heard_s < UNHEARD_S

    def _mark(self, visit: Visit, *, ended: bool) -> None:
        """Note whether a vehicle names its task no more, over a restart too."""
        if visit.load.ended is not ended:
            visit.load = replace(visit.load, ended=ended)
            self._life.commit()

    def _believe(self, visit: Visit) -> None:
        """A vehicle reports its load as put down here: the dock was open for it, if only in an earlier life."""
        if visit.stage is Stage.WAITS and not visit.load.returns:
            visit.stage = Stage.LEAVING

    # --- the end of a visit ---

    def _end(self, visit: Visit, *, moved: bool | None, docks: bool = False) -> None:
        """A vehicle has left, with its load moved or not, or nobody can tell; it stands here again if it `docks`."""
        load, stage, vehicle = visit.load, visit.stage, visit.load.vehicle
        is_in_doubt = moved is None or (moved and stage is Stage.WAITS and bool(load.task))
        moved = (visit.takes if moved is None else moved) and stage is not Stage.WAITS
        if moved and load.change and not self.counts:
            # A body books each load of one name once.
            load = load if load.task or load.epoch else replace(load, epoch=self._life.incarnation)
            self._bookings.say(load)
        elif load.change > 0 and not (load.returns or self.counts):
            self._owed[vehicle, load.task, load.epoch] = load
        elif self.counts or not load.change or stage is Stage.WAITS:
            is_in_doubt = False  # Nothing was to be booked.
        if is_in_doubt:
            self.doubts.note(load)
        elif moved:
            self.doubts.on_told(load)
        self._forget(vehicle)
        if vehicle in self.asked and self.asked[vehicle].load.task == load.task:
            self.forget_request(vehicle)
        if docks and (moved or (visit.takes and stage is Stage.INSIDE)):
            return  # A body shuts its dock when it books, and opens it anew.
        if visit.takes and stage is Stage.INSIDE and not (moved or self.answers):
            # No moving dock can hurt it: it may come back as long as it has a permission.
            self._put(DepartureMemory(vehicle, load.task, load.epoch), Stage.INSIDE)
        else:
            self._close(vehicle)

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


def _has(heartbeat: AtvHeartbeat, item: str) -> bool:
    """Whether a vehicle has such a load on board."""
    return heartbeat.load == item and heartbeat.load_quantity > 0
