"""People are the gate's body: their words go to it with a grant for a delivery warehouse, and its heartbeat tells what is to come."""

from __future__ import annotations

from defaults import PLANT
from effects import instructed, published, remember, sent
from msgspec import UNSET
from rigs import Rig
from seals import granted, trusts_seals

from dray.body import Admit, GateProblem, GateState, GoodsArrived, Word, WordTaken
from dray.memory import Memory
from dray.messages import (
    AdmissionAsked,
    CommandAnswered,
    CommandRefusal,
    GoodsCounted,
    MachineCommand,
    MachineCommandKind,
    PeopleAsBody,
    StationHeartbeat,
)
from dray.messages.heartbeat import GoalToCome
from dray.messages.keys import GATE
from dray.protocol.gate.gate import NO_PEOPLE, DeliveryGate

GOAL = "O1-1.1"
ARRIVED = MachineCommand(command="w1", kind=MachineCommandKind.ARRIVED, item=GOAL, quantity=4)
[WAREHOUSE] = PLANT.delivery_warehouses
HERE = PLANT.areas_near(*PLANT.position_of(WAREHOUSE), 0.0)


class GateRig(Rig):
    """The gate, which has admitted 12 pieces of a goal."""

    def __init__(self, *, people: bool = True, memory: Memory | None = None, late: bool = False) -> None:
        """With a memory it is the next life of its agent, and its body has forgotten all."""
        super().__init__(DeliveryGate(PLANT, incarnation=1 if memory is None else 2, trusts=trusts_seals))
        self.people, self.late = people, late
        self.arrived = {GOAL: 0} if memory is None else {}
        self.memory = memory or {}
        self.start()
        if memory is not None:
            return
        self.on_message("strategist", AdmissionAsked(GOAL, 12, 1, 1))
        self.report(GoodsArrived(GOAL, 0, 12, by_people=people))

    def sense(self) -> GateState:
        return GateState(dict(self.arrived), people=self.people, late=self.late)


def test_a_word_is_passed_on_and_counted_and_answered_when_the_body_has_taken_it() -> None:
    rig = GateRig()
    effects = rig.on_message("gateway", granted(GATE, ARRIVED, areas=HERE))
    assert instructed(effects, Word) == [Word("shift-lead/w1", ARRIVED.kind, GOAL, 4)]
    assert sent(effects, CommandAnswered) == []
    effects = rig.report(GoodsArrived(GOAL, 4, 12, by_people=True))
    [counted] = sent(effects, GoodsCounted)
    assert (counted.arrived, counted.admitted, counted.by_people) == (4, 12, True)
    assert sent(rig.report(WordTaken("shift-lead/w1")), CommandAnswered) == [CommandAnswered("w1", done=True)]


def test_its_heartbeat_tells_what_is_to_come() -> None:
    rig = GateRig()
    rig.report(GoodsArrived(GOAL, 4, 12, by_people=True))
    beats = published(rig.run(rig.now_s + 1.0), StationHeartbeat)
    assert beats[-1].people == PeopleAsBody(goals=(GoalToCome(GOAL, 8),))
    rig.report(GoodsArrived(GOAL, 12, 12, by_people=True))
    beats = published(rig.run(rig.now_s + 1.0), StationHeartbeat)
    assert beats[-1].people == PeopleAsBody()


def test_a_gate_of_people_that_has_forgotten_is_told_what_is_in_and_a_controller_never() -> None:
    for people in (True, False):
        rig = GateRig(people=people)
        rig.report(GoodsArrived(GOAL, 4, 12, by_people=people))
        again = GateRig(people=people, memory=remember({}, rig.all))
        assert instructed(again.all, Admit) == ([Admit(GOAL, 12, arrived=4)] if people else [])
    again = GateRig(memory=remember({}, rig.all))
    [beat] = published(again.run(again.now_s), StationHeartbeat)
    assert beat.people == PeopleAsBody(goals=(GoalToCome(GOAL, 8),))


def test_a_word_from_another_area_is_refused() -> None:
    rig = GateRig()
    elsewhere = [area.id for area in PLANT.file.areas if area.id not in HERE]
    effects = rig.on_message("gateway", granted(GATE, ARRIVED, areas=elsewhere))
    assert instructed(effects, Word) == []
    assert [each.reason for each in sent(effects, CommandAnswered)] == [CommandRefusal.NOT_HERE]


def test_a_gate_that_counts_takes_no_words() -> None:
    rig = GateRig(people=False)
    effects = rig.on_message("gateway", granted(GATE, ARRIVED))
    assert instructed(effects, Word) == []
    [answer] = sent(effects, CommandAnswered)
    assert (answer.reason, answer.detail) == (CommandRefusal.NOT_SUPPORTED, NO_PEOPLE)
    assert all(beat.people is UNSET for beat in published(rig.run(rig.now_s + 6.0), StationHeartbeat))


def test_a_controller_before_which_containers_wait_counts_late_as_people_do_and_takes_no_words() -> None:
    rig = GateRig(people=False, late=True)
    [counted] = sent(rig.report(GoodsArrived(GOAL, 4, 12)), GoodsCounted)
    assert (counted.arrived, counted.by_people) == (4, True)
    [answer] = sent(rig.on_message("gateway", granted(GATE, ARRIVED)), CommandAnswered)
    assert answer.reason == CommandRefusal.NOT_SUPPORTED
    assert all(beat.people is UNSET for beat in published(rig.run(rig.now_s + 6.0), StationHeartbeat))


def test_a_gate_with_a_problem_says_why_and_goes_on() -> None:
    rig, why = GateRig(people=False, late=True), "its controller is not heard: cut"
    rig.report(GateProblem(why))
    [beat] = published(rig.run(rig.now_s), StationHeartbeat)
    assert beat.problem == why
    assert instructed(rig.on_message("strategist", AdmissionAsked(GOAL, 13, 1, 2)), Admit) == [
        Admit(GOAL, 13)
    ]
    [counted] = sent(rig.report(GoodsArrived(GOAL, 4, 13)), GoodsCounted)
    assert (counted.arrived, counted.admitted) == (4, 13)
    # Another reason comes with the next heartbeat, however often it changes.
    rig.report(GateProblem("its controller has a fault: jam"))
    assert published(rig.run(rig.now_s), StationHeartbeat) == []
    rig.report(GateProblem(""))
    [beat] = published(rig.run(rig.now_s), StationHeartbeat)
    assert beat.problem == ""


def test_a_gate_may_begin_with_a_problem() -> None:
    class Away(GateRig):
        def sense(self) -> GateState:
            return GateState({}, late=True, problem="its controller is not heard: cut")

    rig = Away(people=False, late=True)
    [beat] = published(rig.all, StationHeartbeat) or published(rig.run(rig.now_s), StationHeartbeat)
    assert beat.problem == "its controller is not heard: cut"
