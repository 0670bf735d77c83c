"""The table of a task's states: walked to its ends, with all that can happen in each state.

Whatever happens, a coordinator changes a task's state only as the table has it, else it raises. And nothing stands in the
table that no walk comes to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import pytest
from spoken import rhb
from transports_rig import TransportsRig

from dray.messages import THING, Phase, Reason, Resigned, Role, TakenOver, Transport
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.task_state import TRANSITIONS, TaskState
from dray.protocol.liveness.failure_detector import UNNAMED_S
from dray.protocol.liveness.suspicion import LATENESS_MAX_S
from dray.protocol.transports.transports import Transports
from dray.states import States

SILENT_S = LATENESS_MAX_S + 8.0
"""Longer than any bound of these links, shorter than the time in which goods are given up."""

FIRST, SECOND = "ATV1", "ATV2"


class Walk(TransportsRig):
    """A coordinator's one task at one point of its way, and the changes of its state so far.

    Args:
        load: `material`, `goods`, or a `thing` without master data, which exists once as goods do and is counted as material is.
        restored: an earlier life has opened it, and told so much: nothing, a carrier, a carrier with goods on board.
        monkey: notes the changes.
    """

    def __init__(self, load: str, restored: str, monkey: Any) -> None:
        super().__init__()
        self.load, self.exists_once = load, load != "material"
        self.seen: set[tuple[TaskState, TaskState]] = set()
        enter = States.enter

        def note(states: Any, state: Any) -> None:
            before = states.now
            enter(states, state)
            if isinstance(state, TaskState):
                self.seen.add((before, state))

        monkey.setattr(States, "enter", note)
        monkey.setattr(Transports, "is_missing", lambda _self, _task: True)
        self.open_work()
        if restored:
            memory = msgspec.structs.replace(
                self.task.memory(),
                primary="" if restored == "nobody" else FIRST,
                loaded=restored == "loaded",
            )
            self.transports._open.clear()
            self.life.cancel(("primary auction", "T1"))
            self.transports.restore(memory, self.now_s)

    def open_work(self) -> OpenTask:
        task = self.open()
        assert isinstance(task.work, Transport)
        if self.load == "goods":
            task.work = msgspec.structs.replace(task.work, goal="G1", item="pump-p3")
        elif self.load == "thing":
            task.work = msgspec.structs.replace(task.work, item=THING)
        return task

    @property
    def ended(self) -> bool:
        return self.transports.get("T1") is None

    # --- what can happen ---

    def somebody_accepts(self) -> None:
        if self.task.state is TaskState.UNASSIGNED:
            self.run(self.now_s + 11.0)
            atv = SECOND if self.task.epoch % 2 == 0 else FIRST
            self.bids(epoch=self.task.epoch, **{atv: 50.0})
            self.say_yes(Role.PRIMARY)

    def somebody_watches(self) -> None:
        if self.task.primary and self.task.watch is not None:
            other = SECOND if self.task.primary == FIRST else FIRST
            self.bids(role=Role.SECONDARY, epoch=self.task.epoch, **{other: 60.0})
            self.say_yes(Role.SECONDARY)

    def say_yes(self, role: Role) -> None:
        """Whoever is asked next accepts at once."""
        before = len(self.asked(role))
        for _ in range(30):
            self.run(self.now_s + 0.1)
            if len(self.asked(role)) > before:
                self.accepts(self.asked(role)[-1], role, epoch=self.task.epoch)
                return

    def works(self) -> None:
        """The carrier and the secondary are heard for a while."""
        for _ in range(3):
            if not self.ended:
                self.beat(self.task.primary)
                self.beat(self.task.secondary)
                self.run(self.now_s + 1.0)

    def primary_is_silent(self) -> None:
        for _ in range(int(SILENT_S)):
            if not self.ended and self.task.state is not TaskState.SUSPECTED:
                self.beat(self.task.secondary)
                self.run(self.now_s + 1.0)

    def time_passes(self) -> None:
        self.run(self.now_s + SILENT_S)

    def goods_are_given_up(self) -> None:
        self.run(self.now_s + 700.0)

    def primary_speaks_again(self) -> None:
        self.beat(self.task.primary)

    def beat(self, atv: str) -> None:
        """A vehicle that keeps its contract says so."""
        if atv:
            self.seq += 1
            said = self.heartbeat(atv)
            briefs = [msgspec.structs.replace(each, epoch=self.task.epoch) for each in said.watches]
            carried = said.task and msgspec.structs.replace(said.task, epoch=self.task.epoch)
            said = msgspec.structs.replace(said, task=carried, watches=tuple(briefs))
            self.transports.on_heartbeat(said, self.now_s)

    def secondary_takes_over(self) -> None:
        if self.task.secondary:
            said = TakenOver("T1", self.task.epoch + 1, self.task.primary, "silent", self.now_s + 90.0)
            said = msgspec.structs.replace(said, at_s=self.now_s)
            self.transports.on_taken_over(self.task.secondary, said, self.now_s)

    def primary_gives_back(self) -> None:
        if self.task.primary:
            said = Resigned(
                task="T1", epoch=self.task.epoch, role=Role.PRIMARY, reason=Reason.GRACEFUL_SHUTDOWN
            )
            self.transports.on_resigned(self.task.primary, said, self.now_s)

    def secondary_gives_back(self) -> None:
        if self.task.secondary:
            said = Resigned(task="T1", epoch=self.task.epoch, role=Role.SECONDARY, reason=Reason.HAS_WORK)
            self.transports.on_resigned(self.task.secondary, said, self.now_s)

    def primary_has_forgotten(self) -> None:
        for _ in range(int(UNNAMED_S) + 2):
            if not self.ended and self.task.primary:
                self.now_s += 1.0
                self.seq += 1
                self.transports.on_heartbeat(rhb(self.task.primary, self.seq, self.now_s), self.now_s)

    def goods_leave(self) -> None:
        if self.task.primary and self.exists_once:
            self.seq += 1
            beat = rhb(self.task.primary, self.seq, self.now_s, task="T1")
            assert beat.task is not None
            brief = msgspec.structs.replace(beat.task, epoch=self.task.epoch, phase=Phase.CARRYING)
            self.transports.on_heartbeat(msgspec.structs.replace(beat, task=brief), self.now_s)

    def goods_leave_unheard(self) -> None:
        """The machine's own senses tell, while the carrier is silent."""
        if self.task.primary and self.exists_once:
            self.transports.failover.note_loaded(self.task)

    def goods_come_back(self) -> None:
        if self.task.is_loaded:
            self.transports.reopen(self.task, "the goods are back", self.now_s)

    def load_is_counted(self) -> None:
        if self.task.primary and self.load != "goods" and not self.task.is_counted:
            self.task.states.enter(TaskState.COUNTED)

    def is_disputed_again(self) -> None:
        if self.task.primary and not self.task.is_counted:
            self.transports.hold(self.task, self.now_s)

    def carriers_fail_at_a_dock(self) -> None:
        if self.task.primary and not self.task.is_counted and not self.task.is_loaded:
            self.transports.hold(self.task, self.now_s, fails_at="M8")

    def person_finds_the_load(self) -> None:
        if self.task.is_held:
            self.transports.conclude(self.task, self.now_s)

    def person_finds_nothing(self) -> None:
        if self.task.is_held:
            self.transports.resume(self.task, self.now_s)

    def life_begins_anew_while_held(self) -> None:
        if self.task.is_held:
            memory = self.task.memory()
            self.transports.restore(memory, self.now_s)

    def load_is_handed_over(self) -> None:
        self.transports.close(self.task, "delivered")

    def is_not_needed(self) -> None:
        self.transports.close(self.task, "withdrawn")


HAPPENINGS: tuple[Callable[[Walk], None], ...] = (
    Walk.somebody_accepts,
    Walk.somebody_watches,
    Walk.works,
    Walk.primary_is_silent,
    Walk.time_passes,
    Walk.goods_are_given_up,
    Walk.primary_speaks_again,
    Walk.secondary_takes_over,
    Walk.primary_gives_back,
    Walk.secondary_gives_back,
    Walk.primary_has_forgotten,
    Walk.goods_leave,
    Walk.goods_leave_unheard,
    Walk.goods_come_back,
    Walk.load_is_counted,
    Walk.is_disputed_again,
    Walk.carriers_fail_at_a_dock,
    Walk.person_finds_the_load,
    Walk.person_finds_nothing,
    Walk.life_begins_anew_while_held,
    Walk.load_is_handed_over,
    Walk.is_not_needed,
)

STARTS = [
    (load, restored)
    for load in ("material", "goods", "thing")
    for restored in ("", "nobody", "carried", "loaded")
    if load != "material" or restored != "loaded"
]


def walks() -> Iterator[Walk]:
    """Every state that a task comes to, by every happening, from every start."""
    for load, restored in STARTS:
        paths: list[tuple[Callable[[Walk], None], ...]] = [()]
        known = set()
        for path in paths:
            with pytest.MonkeyPatch.context() as patch:
                walk = Walk(load, restored, patch)
                for happening in path:
                    if not walk.ended:
                        happening(walk)
            yield walk
            if walk.ended:
                continue
            task = walk.task
            heard = task.contract.detector is not None and task.contract.detector.last is not None
            key = (task.state, task.secondary, heard, min(task.epoch, 3), bool(task.trouble))
            if key not in known:
                known.add(key)
                paths += [(*path, happening) for happening in HAPPENINGS]


def test_no_walk_leaves_the_table_and_none_of_it_is_out_of_reach() -> None:
    seen: set[tuple[TaskState, TaskState]] = set()
    for walk in walks():
        seen |= walk.seen
        if not walk.ended:
            assert bool(walk.task.primary) == (walk.task.state not in (TaskState.UNASSIGNED, TaskState.HELD))
    table = {(state, after) for state, row in TRANSITIONS.items() for after in row}
    assert seen == table, f"never seen: {sorted(table - seen)}"
