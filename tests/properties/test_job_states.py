"""The table of a transport job's states: walked to its ends, with all that can happen in each state.

Whatever happens, a job changes its state only as the table has it, else it raises. And nothing stands in the table that no
walk comes to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from defaults import PLANT
from effects import instructed
from spoken import transport
from vehicle_states import standing

from dray.body import Drive, Drop, Pick, WayDone
from dray.memory import Contract
from dray.messages import DockHeld, DockOpened, HandoverAccepted, Phase, Superseded
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.job.job_messages import GIVE_UP_AFTER
from dray.protocol.vehicle.job.job_state import LOADED, MANOEUVRES, TRANSITIONS, VOID, JobState, JobStates
from dray.protocol.vehicle.job.transport_job import TRIES, TransportJob

MATERIAL: dict[str, Any] = {}
GOODS: dict[str, Any] = {
    "item": "pump-p3",
    "quantity": 24,
    "sources": ("M8",),
    "destination": "DELIVERY",
    "goal": "G8",
}


class Walk:
    """A job at one point of its way, and the changes of its state so far."""

    def __init__(
        self,
        work: dict[str, Any],
        phase: Phase | None,
        *,
        loaded: bool,
        void: str,
        ahead: str | None,
        monkey: Any,
    ) -> None:
        self.now_s = 0.0
        self.life = Life()
        self.out = self.life.effects
        self.driver = Driver(PLANT, "light", self.life)
        carried = transport(**work)
        at = "p3" if ahead is None else PLANT.node_of(carried.sources[0])
        state = standing(PLANT, at, next_node=ahead or at)
        self.driver.sense(state)
        self.driver.take_control(state, 0.0)
        self.job = TransportJob(
            Contract(
                task="M8-1",
                epoch=1,
                work=carried,
                coordinator="M8",
                source=carried.sources[0],
                promised_s=100.0,
                deadline_s=300.0,
                phase=phase or Phase.APPROACHING,
                cancelled=void,
            ),
            plant=PLANT,
            vehicle_type="light",
            driver=self.driver,
            life=self.life,
        )
        self.load = carried.item if loaded else ""
        self.seen: set[tuple[JobState, JobState]] = set()
        enter = JobStates.enter

        def note(states: JobStates, state: JobState) -> None:
            before = states.now
            enter(states, state)
            if states is self.job._states:
                self.seen.add((before, state))

        monkey.setattr(JobStates, "enter", note)
        if phase is None:
            self.job.set_off(0.0)
        else:
            self.job.resume(self.load, 0.0)

    # --- what can happen ---

    def arrives(self) -> None:
        if self.driver.way:
            way = instructed(self.life.effects, Drive)[-1]
            self.driver.on_done(WayDone(order=way.order, node=way.nodes[-1]), 0.0)
            self.job.arrived(self.now_s)

    def does(self) -> None:
        if self.job.state in MANOEUVRES:
            picks = self.job.state in (JobState.PICKING, JobState.VOID_PICKING)
            self.load = self.job.work.item if picks else ""
            self.job.action_done(self._order, self.now_s)

    def fails(self) -> None:
        if self.job.state in MANOEUVRES:
            self.job.action_failed(self._order, "no contact", self.now_s)

    @property
    def _order(self) -> int:
        return max(act.order for kind in (Pick, Drop) for act in instructed(self.life.effects, kind))

    def opens(self) -> None:
        for station in (self.job.source, "M8"):
            self.job.on_answer(DockOpened(task="M8-1", epoch=1, station=station), self.now_s)

    def holds(self) -> None:
        self.now_s += 200.0
        held = DockHeld(task="M8-1", epoch=1, station=self.job.source, reason="has none")
        self.job.on_answer(held, self.now_s)

    def confirms(self) -> None:
        self.job.on_answer(HandoverAccepted(task="M8-1", epoch=1), self.now_s)

    def supersedes(self) -> None:
        self.job.on_answer(Superseded(task="M8-1", epoch=2), self.now_s)

    def asks_to_leave(self) -> None:
        self.job.give_back("graceful shutdown", self.now_s)

    def refuses_way(self) -> None:
        self.job.way_refused(self.now_s)
        self.waits()

    def waits(self) -> None:
        if self.life.timers.next_s < NEVER_S and self.job.state not in MANOEUVRES and not self.job.ended:
            self.now_s = max(self.now_s, self.life.timers.next_s)
            if list(self.life.timers.due(self.now_s)):
                self.job.wake(self.load, self.now_s)

    def hears_nothing(self) -> None:
        for _ in range(GIVE_UP_AFTER + 1):
            self.waits()

    def finds_load(self) -> None:
        if self.job.state not in MANOEUVRES and self.job.state not in LOADED:
            self.load = self.job.work.item
            self.refuses_way()

    def finds_another_load(self) -> None:
        if self.job.state not in MANOEUVRES and self.job.state not in LOADED:
            self.load = "something else"
            self.refuses_way()

    def loses_load(self) -> None:
        if self.job.state not in MANOEUVRES and self.job.state in LOADED:
            self.load = ""
            self.refuses_way()


HAPPENINGS: tuple[Callable[[Walk], None], ...] = (
    Walk.arrives,
    Walk.does,
    Walk.fails,
    Walk.opens,
    Walk.holds,
    Walk.confirms,
    Walk.supersedes,
    Walk.asks_to_leave,
    Walk.refuses_way,
    Walk.waits,
    Walk.hears_nothing,
    Walk.finds_load,
    Walk.finds_another_load,
    Walk.loses_load,
)

STARTS = [
    (work, phase, loaded, void, ahead)
    for work in (MATERIAL, GOODS)
    for phase in (None, *Phase)
    for loaded in (False, True)
    for void in ("", "superseded")
    for ahead in (None, "", "p3")  # Elsewhere, at the source, or on its way away from it.
    if phase is not None or not (loaded or void)
    if ahead is None or phase is Phase.LOADING
]


def walks(monkey: Any) -> Iterator[Walk]:
    """Every state that a job comes to, by every happening, from every start."""
    for work, phase, loaded, void, ahead in STARTS:
        paths: list[tuple[Callable[[Walk], None], ...]] = [()]
        known = set()
        for path in paths:
            with monkey.context() as patch:
                walk = Walk(work, phase, loaded=loaded, void=void, ahead=ahead, monkey=patch)
                for happening in path:
                    if not walk.job.ended:
                        happening(walk)
            yield walk
            job = walk.job
            may_be_picking = walk.now_s < job._pick_over_s
            key = (
                job.state,
                min(job._failed, TRIES),
                job._may_be_dropping,
                may_be_picking,
                bool(walk.driver.way),
                walk.load,
            )
            if key not in known and not job.ended:
                known.add(key)
                paths += [(*path, happening) for happening in HAPPENINGS]


def test_no_walk_leaves_the_table_and_none_of_it_is_out_of_reach() -> None:
    seen: set[tuple[JobState, JobState]] = set()
    ends = 0
    for walk in walks(pytest.MonkeyPatch):
        seen |= walk.seen
        ends += walk.job.state is JobState.ENDED
        assert bool(walk.job.ended) == (walk.job.state is JobState.ENDED)
        assert walk.job.is_void == (walk.job.state in VOID)
    table = {(state, after) for state, row in TRANSITIONS.items() for after in row}
    assert seen == table, f"never seen: {sorted(table - seen)}"
    assert ends > 100
