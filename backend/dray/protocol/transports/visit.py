"""One vehicle at a dock, from its request until it has left and its load is decided.

    WAITS --the dock opens--> INSIDE --its permission ends--> LEAVING --it has left--> over: its load has moved, or not
      |                         |                               |
      +-------------------------+--it was heard elsewhere-------+--> GONE: whether it has taken its load is asked

A heartbeat decides whether the vehicle is here still, and if not, whether it has moved its load. A load to take is on board
then, and one to bring is not. The vehicle may have been silent meanwhile, and its agent started again, also without notes; its
body goes on all the same.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from msgspec.structs import replace

from dray.memory import DepartureMemory
from dray.messages import AtvHeartbeat, Docked, Phase
from dray.messages.heartbeat import GOODS_ABOARD
from dray.protocol.runtime.events import NEVER_S

UNHEARD_S = 8.0
"""Too short for a vehicle to unload elsewhere and end its task; long enough for several heartbeats."""

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

    @property
    def renewed(self) -> Stage:
        """The stage of a vehicle that is here again, for the same load."""
        return {Stage.LEAVING: Stage.INSIDE, Stage.GONE: Stage.WAITS}.get(self, self)


class Sighting(NamedTuple):
    """What a vehicle's heartbeat tells of its visit."""

    is_here: bool
    """It is at the dock's node."""
    names_task: bool
    """It has the task of the visit."""
    phase: Phase | None
    """The phase of its task, whichever that is; None without a task."""
    has_load: bool
    """It has the load of the visit on board, or one like it."""
    is_empty: bool
    """It has nothing on board."""
    left_empty: bool
    """It has lost its memory here, and has left with nothing on board."""
    life: int
    """Its incarnation."""
    was_heard: bool
    """It was heard at the task until now (`UNHEARD_S`)."""

    @property
    def is_loaded(self) -> bool:
        """Whether it has loaded what its task is for."""
        return self.has_load or self.phase in GOODS_ABOARD

    @property
    def returns_load(self) -> bool:
        """Whether it brings such a load back: that of its task, or one that it has found on board."""
        return self.has_load and self.phase is Phase.RETURNING


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
    def brings(self) -> bool:
        """Whether it may bring a load."""
        return self.load.brings

    @property
    def takes(self) -> bool:
        """Whether it may take a load; otherwise it may bring one, or nothing is to be booked."""
        return self.load.takes

    @property
    def is_unnamed(self) -> bool:
        """Whether an earlier life let it in, and no notes say for what."""
        return not self.load.task

    def is_for(self, task: str, epoch: int) -> bool:
        """Whether it is a visit for an epoch of a task."""
        return (self.load.task, self.load.epoch) == (task, epoch)

    def is_of(self, load: DepartureMemory) -> bool:
        """Whether it is a visit for this load, in this direction."""
        return self.is_for(load.task, load.epoch) and self.load.change * load.change >= 0

    def was_heard(self, now_s: float) -> bool:
        """Whether it was recently heard at its task."""
        return now_s - self.heard_s < UNHEARD_S

    def see(self, heartbeat: AtvHeartbeat, node: str, now_s: float) -> Sighting:
        """Note that it is heard. Returns what that tells.

        Args:
            heartbeat: what it says.
            node: the dock's node.
            now_s: the present time (plant clock, s).
        """
        task = heartbeat.task
        names_task = task is not None and self.is_for(task.task, task.epoch)
        if names_task:
            self.heard_s, self.named_in = now_s, heartbeat.incarnation
        return Sighting(
            is_here=heartbeat.node == node,
            names_task=names_task,
            phase=None if task is None else task.phase,
            has_load=heartbeat.load == self.load.item and heartbeat.load_quantity > 0,
            is_empty=not heartbeat.load,
            left_empty=heartbeat.left_empty == node,
            life=heartbeat.incarnation,
            was_heard=self.was_heard(now_s),
        )

    # --- whether it is here still ---

    def is_here_still(self, seen: Sighting) -> bool:
        """Whether it has not left yet. One that is to load may be heard elsewhere first: it has not come yet."""
        if self.takes and seen.names_task and not seen.is_loaded and self.stage is not Stage.LEAVING:
            return True
        if not seen.is_here or self.stage is Stage.GONE:
            return False
        may_stay = self._may_go_on_loading(seen) if self.takes else self._may_report_yet(seen)
        return may_stay or self._is_inside(seen)

    def _is_inside(self, seen: Sighting) -> bool:
        """Whether it loads, unloads or returns its load, or one that it has found on board."""
        is_its_task = seen.names_task or self.is_unnamed
        return seen.returns_load or (is_its_task and seen.phase in _MAY_BE_INSIDE)

    def _may_go_on_loading(self, seen: Sighting) -> bool:
        """Whether its body may be loading although its agent, started again without notes, does not name the task.

        A life that has named the task has ended it. With the load on board it has loaded, if the dock was open.
        """
        if seen.life == self.named_in or (seen.has_load and self.stage is not Stage.WAITS):
            return False
        return seen.phase is None or seen.was_heard or self.is_unnamed or self.load.ended

    def _may_report_yet(self, seen: Sighting) -> bool:
        """Whether it may still report what it has brought, or that it has lost its memory here."""
        return self.is_unnamed and self.brings and seen.phase is None and seen.is_empty

    # --- what it has moved when it has left ---

    def is_told_down(self, seen: Sighting) -> bool:
        """Whether it tells that its load to bring is down here."""
        hands_over = seen.names_task and seen.phase is Phase.HANDING_OVER
        return not self.takes and (seen.left_empty or hands_over)

    def note_down(self) -> None:
        """Its load is said to be down here: the dock was open for it, if only in an earlier life."""
        if self.stage is Stage.WAITS and not self.load.returns:
            self.stage = Stage.LEAVING

    def has_moved(self, seen: Sighting) -> bool | None:
        """Whether it has moved its load, now that it has left; None if that is unknown."""
        if seen.left_empty:
            return not self.takes
        return self._has_taken(seen) if self.takes else self._has_brought(seen)

    def _has_taken(self, seen: Sighting) -> bool | None:
        if seen.names_task:
            return seen.is_loaded
        # A vehicle that was heard elsewhere without such a load has it from there; so has one, perhaps, that had ended its task
        # before the dock was opened for it.
        is_from_here = self.stage is not Stage.GONE and (
            seen.is_here or seen.was_heard or not self.load.ended
        )
        if seen.has_load and is_from_here:
            return True
        has_ended = seen.was_heard or self.load.ended or self._stands_idle(seen)
        return False if has_ended else None

    def _has_brought(self, seen: Sighting) -> bool | None:
        is_its_task = seen.names_task or (self.is_unnamed and seen.phase is not None)
        if is_its_task or seen.returns_load or self._stands_idle(seen):
            return not (seen.has_load or (is_its_task and seen.phase is Phase.RETURNING))
        # No vehicle ends a task with its load on board.
        return True if seen.was_heard else None

    def _stands_idle(self, seen: Sighting) -> bool:
        """Whether it stands here without a task, and has not been elsewhere."""
        return seen.is_here and seen.phase is None and self.stage is not Stage.GONE

    # --- a request of its vehicle for the next load ---

    def may_be_for(self, docked: Docked, *, unloads: bool) -> bool:
        """Whether an earlier life may have let it in for the load that is asked for: it may be loading it."""
        is_same = not docked.item or self.load.item in ("", docked.item)
        return self.is_unnamed and is_same and not (self.brings or unloads)

    def has_moved_before(self, docked: Docked, *, unloads: bool, was_heard: bool) -> bool | None:
        """Whether it has moved its load before its vehicle asked for another one here; None if that is unknown."""
        if not self.takes:
            return False if unloads else was_heard or None
        if unloads and docked.item == self.load.item:
            return True
        return False if was_heard or self.load.ended else None

    # --- over a restart ---

    @property
    def is_noted(self) -> bool:
        """Whether the next life must know of it. A body may remember for whom it opens the dock, and not who was let in."""
        return self.is_followed or self.stage is Stage.WAITS

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


def stage_of(memory: DepartureMemory) -> Stage:
    """The stage in which an earlier life has left a visit."""
    if not memory.let_in:
        return Stage.WAITS
    if memory.gone:
        return Stage.GONE
    return Stage.INSIDE if memory.permitted else Stage.LEAVING
