"""A job keeps its load through everything, and ends when answers come.

A vehicle holds one contract of a scripted coordinator. Answers come in time, late, twice, with the wrong epoch,
from strangers or not at all; manoeuvres fail; the contract is cancelled at any moment; the software crashes at
any moment and goes on from what it has written down. The vehicle's body is a plain one that refuses what
cannot be done.
"""

from __future__ import annotations

from collections.abc import Callable

import hypothesis.strategies as st
from actors import Actor
from bodies import PlainVehicle
from defaults import PLANT
from examples import examples
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from spoken import award, transport

from dray.body import Drop, Pick
from dray.messages import (
    Docked,
    DockHeld,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Phase,
    Reason,
    Release,
    Role,
    Superseded,
    Withdrawn,
)
from dray.messages.fact import ContractEnded, ContractTaken, PhaseEntered
from dray.protocol.runtime.events import Effect, Instruct, Record, Send
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.vehicle.atv import Atv

TASK = "M8-1"
MATERIAL = transport()
GOODS = transport(
    item="pump-p3",
    quantity=12,
    sources=("M8",),
    destination=PLANT.delivery_warehouses[0],
    goal="G1",
)

ENDS_WITHIN_S = 1500.0
"""Every way, every retry and every question, several times over."""

OVER = {
    "released": lambda: Release(task=TASK, epoch=1, role=Role.PRIMARY, reason=Reason.NOT_NEEDED),
    "superseded": lambda: Superseded(task=TASK, epoch=2),
    "withdrawn": lambda: Withdrawn(task=TASK, epoch=1, reason=Reason.NOT_NEEDED),
}

STALE: tuple[Callable[[], Message], ...] = (
    lambda: DockOpened(task=TASK, epoch=0, station="M8"),
    lambda: DockOpened(task="M8-9", epoch=1, station="M8"),
    lambda: DockOpened(task=TASK, epoch=1, station="S3"),
    lambda: HandoverAccepted(task=TASK, epoch=0),
    lambda: HandoverAccepted(task="M8-9", epoch=1),
    lambda: Superseded(task="M8-9", epoch=2),
    lambda: Withdrawn(task=TASK, epoch=0, reason=Reason.NOT_NEEDED),
    lambda: Release(task=TASK, epoch=0, role=Role.PRIMARY, reason=Reason.NOT_NEEDED),
)
"""Never true of this contract, whenever they come."""


class Carrying(RuleBasedStateMachine):
    """One contract of one vehicle."""

    @initialize(goods=st.booleans(), node=st.sampled_from(["p3", "s3", "m8", "p1"]))
    def begins(self, goods: bool, node: str) -> None:
        self.work = GOODS if goods else MATERIAL
        self.source = "M8" if goods else "S3"
        self.now_s = 0.0
        self.failing = 0
        self.opened = 0
        """Docks that were opened to it and not used yet."""
        self.put: list[tuple[str, str]] = []
        """Where loads were put down, and for what goal."""
        self.taken = 0
        self.questions: list[Message] = []
        self.handovers = 0
        self.phase = Phase.APPROACHING
        self.ended: list[str] = []
        self.body = PlainVehicle("ATV1", PLANT, node, self.transfer)
        self.actor = Actor(_light, self.body, self.see)
        self.actor.start(0.0)
        self.told("M8", award(task=TASK, work=self.work, source=self.source))
        assert not self.ended

    # --- what happens ---

    @rule(span_s=st.sampled_from([0.1, 1.0, 3.0, 6.0, 15.0, 40.0]))
    def time_passes(self, span_s: float) -> None:
        handed_over = self.phase is Phase.HANDING_OVER and not self.ended and self.actor.agent is not None
        before = self.handovers
        self.now_s += span_s
        self.actor.run(self.now_s)
        if handed_over and not self.ended and span_s > ASK_AGAIN_S:
            assert self.handovers > before, "it does not repeat its handover"

    @rule()
    def is_answered(self) -> None:
        """The coordinator answers the last question, perhaps once more than needed."""
        if not self.questions:
            return
        question = self.questions[-1]
        if isinstance(question, Docked):
            self.opened = 1
            opened = DockOpened(task=TASK, epoch=1, station=question.station)
            self.told(self.dock_owner(question.station), opened)
        elif isinstance(question, Handover):
            self.told("M8", HandoverAccepted(task=TASK, epoch=1))

    @rule()
    def is_held(self) -> None:
        if self.questions and isinstance(self.questions[-1], Docked):
            station = self.questions[-1].station
            held = DockHeld(task=TASK, epoch=1, station=station, reason="the buffer is full")
            self.told(self.dock_owner(station), held)

    @rule(message=st.sampled_from(STALE), sender=st.sampled_from(["M8", "M7"]))
    def hears_what_is_stale(self, message: Callable[[], Message], sender: str) -> None:
        self.told(sender, message())

    @rule(message=st.sampled_from(sorted(OVER)))
    def stranger_says_it_is_over(self, message: str) -> None:
        self.told("M7", OVER[message]())

    @rule(reason=st.sampled_from(sorted(OVER)), one_of=st.integers(1, 8))
    def is_cancelled(self, reason: str, one_of: int) -> None:
        """Seldom: little is to be seen of a contract that ends at its beginning."""
        if one_of == 8:
            self.told("M8", OVER[reason]())

    @rule()
    def fork_slips(self) -> None:
        self.failing += 1

    @rule(stopped_s=st.sampled_from([0.5, 4.0, 20.0]))
    def has_a_problem(self, stopped_s: float) -> None:
        self.actor.report(self.body.break_down("the way is blocked", self.now_s), self.now_s)
        self.time_passes(stopped_s)
        self.actor.report(self.body.repair(self.now_s), self.now_s)

    @rule(down_s=st.sampled_from([0.0, 1.0, 8.0]))
    def crashes_and_starts(self, down_s: float) -> None:
        self.actor.crash()
        self.time_passes(down_s)
        self.actor.start(self.now_s)

    @rule(kind=st.sampled_from([Pick, Drop]), later_s=st.sampled_from([0.0, 2.5]))
    def crashes_while_the_load_changes_hands(self, kind: type[Pick | Drop], later_s: float) -> None:
        self.goes_on_until(kind)
        self.time_passes(later_s)
        self.crashes_and_starts(0.5)

    def goes_on_until(self, kind: type[Pick | Drop]) -> None:
        """Answers come in time until a load is picked up or put down."""
        for _ in range(100):
            if self.ended or isinstance(self.body.action, kind):
                return
            self.time_passes(1.0)
            self.is_answered()
            self.questions.clear()

    # --- what must hold ---

    @invariant()
    def load_is_never_lost(self) -> None:
        on_board = 1 if self.body.load[0] else 0
        assert self.taken - len(self.put) == on_board

    @invariant()
    def it_waits_for_something_until_it_has_ended(self) -> None:
        assert len(self.ended) <= 1 + self.actor.incarnation
        if not self.ended:
            assert self.actor.next_s < float("inf")

    def teardown(self) -> None:
        """Answers come now, and nothing fails any more."""
        if not hasattr(self, "actor"):
            return
        self.failing = 0
        until_s = self.now_s + ENDS_WITHIN_S
        while not self.ended and self.now_s < until_s:
            self.time_passes(1.0)
            self.is_answered()
            self.questions.clear()
        assert self.ended, f"it is still {self.phase}"
        self.time_passes(60.0)
        assert not self.body.load[0], f"it has ended ({self.ended}) with {self.body.load} on board"
        delivered = [place for place in self.put if place == (self.work.destination, self.work.goal)]
        assert len(delivered) <= 1, "it was brought twice"
        if self.ended == ["handed_over"]:
            assert self.put[-1] == (self.work.destination, self.work.goal)

    # --- how it is played ---

    def told(self, sender: str, message: Message) -> None:
        self.actor.on_message(sender, message, self.now_s)

    def dock_owner(self, station: str) -> str:
        """Who opens a dock: a storage's own station, and the coordinator everywhere else."""
        return station if station == "S3" else "M8"

    def transfer(self, _atv: str, action: Pick | Drop, load: tuple[str, int]) -> str:
        if self.failing:
            self.failing -= 1
            return "the fork slips"
        if action.station == "M8":
            if not self.opened:
                return "the dock is shut"
            self.opened = 0
        if isinstance(action, Pick):
            self.taken += 1
        else:
            self.put.append((action.station, action.goal))
        return ""

    def see(self, effect: Effect) -> None:
        if isinstance(effect, Send) and isinstance(effect.message, Docked | Handover):
            docks = isinstance(effect.message, Docked)
            assert effect.to == (self.dock_owner(effect.message.station) if docks else "M8")
            self.questions.append(effect.message)
            self.handovers += isinstance(effect.message, Handover)
        elif isinstance(effect, Instruct) and isinstance(effect.instruction, Pick | Drop):
            self.see_manoeuvre(effect.instruction)
        elif isinstance(effect, Record):
            if isinstance(effect.fact, PhaseEntered):
                self.phase = effect.fact.phase
                self.questions.clear()
            elif isinstance(effect.fact, ContractEnded):
                self.ended.append(effect.fact.reason)
            elif isinstance(effect.fact, ContractTaken):
                assert not self.ended

    def see_manoeuvre(self, action: Pick | Drop) -> None:
        """Never two at once in one life, and at the coordinator's own dock only when asked first."""
        running = self.body.action
        if isinstance(running, Pick | Drop):
            assert _life(running.order) != _life(action.order), f"{running} and {action} at once"
        if action.station == "M8":
            assert self.opened, f"{action} without having asked"


def _life(order: int) -> int:
    return order // 1_000_000


def _light(life: int) -> Atv:
    return Atv("ATV1", PLANT, vehicle_type="light", incarnation=life)


TestCarrying = Carrying.TestCase
TestCarrying.settings = settings(max_examples=examples(200), stateful_step_count=15)


def test_what_an_earlier_life_has_put_down_is_handed_over_and_not_brought_again() -> None:
    trip = Carrying()
    trip.begins(goods=False, node="p3")
    trip.goes_on_until(Drop)
    trip.crashes_and_starts(0.5)
    trip.teardown()
    assert trip.put == [("M8", "")]
    assert trip.ended == ["handed_over"]
