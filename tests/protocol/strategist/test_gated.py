"""A strategist whose gate is an agent of its own: it begins when the gate was heard, and what it says there is repeated, numbered and noted."""

from __future__ import annotations

from bureau import announced, contract, order
from defaults import PLANT
from effects import facts, instructed, remember, sent
from rigs import Rig
from spoken import mhb

from dray.body import Admit
from dray.body.gate import EVERY_RELEASE
from dray.memory import Memory, ShutWord
from dray.messages import (
    AdmissionAsked,
    Brought,
    Confirmed,
    CountAcknowledged,
    GateAsked,
    GateReported,
    GoalBrief,
    GoodsCounted,
    HolderAcknowledged,
    HolderReported,
    OrderCancelled,
    OrderClaimed,
    OrderTaken,
    StationHeartbeat,
)
from dray.messages.base import COUNT_MAX
from dray.messages.fact import GoodsDelivered, MemoryLost, OrderFulfilled
from dray.messages.gate import HeldOrder, OrderHeld
from dray.messages.keys import GATE
from dray.messages.overtaken import OVERTAKES_S
from dray.protocol.runtime.events import Effect, Ignore, Started
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.strategist.gated import OLD, GatedStrategist
from dray.protocol.strategist.order_holding import REPORTED_S, TURN_S
from dray.protocol.strategist.peers import PEER_SILENCE_S

OTHER = "strategist2"


class GatedRig(Rig):
    """A strategist with nothing at hand."""

    def __init__(
        self, *, memory: Memory | None = None, life: int = 1, shared: bool = False, lost: str = ""
    ) -> None:
        super().__init__(GatedStrategist(PLANT, incarnation=life, others=(OTHER,) if shared else ()))
        self.memory = memory or {}
        self.handle(Started(None, self.memory, lost))

    def told(self, *held: HeldOrder, after: str = "", more: bool = False, since: int = 1) -> list[Effect]:
        return self.on_message(GATE, GateReported(after, held, more, since))

    def answered(
        self, goal: str, arrived: int = 0, *brought: Brought, number: int | None = None
    ) -> list[Effect]:
        """The gate answers the last word about a goal."""
        word = [each for each in sent(self.all, AdmissionAsked, to=GATE) if each.goal == goal][-1]
        said = word.number if number is None else number
        counted = GoodsCounted(goal, arrived, word.quantity, self.agent.incarnation, said, brought)
        return self.on_message(GATE, counted)

    def next_life(self, **options: bool) -> GatedRig:
        again = GatedRig(memory=remember(self.memory, self.all), life=self.agent.incarnation + 1, **options)
        again.now_s = self.now_s
        return again


def making() -> tuple[GatedRig, str]:
    """M7 makes the only goal of an order of 24 pumps."""
    rig = GatedRig()
    rig.told()
    rig.on_message("gateway", order(pump=24))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    return rig, goal


def holding() -> GatedRig:
    """It holds an order, one strategist of two."""
    rig = GatedRig(shared=True)
    rig.told()
    rig.on_message("gateway", order(pump=24))
    rig.run(rig.now_s + 3 * TURN_S)
    rig.on_message(GATE, HolderReported(OrderHeld("O1", "strategist", 1)))
    return rig


def test_it_does_nothing_before_the_gate_was_heard_and_asks_it_again_and_again() -> None:
    rig = GatedRig()
    assert sent(rig.all, GateAsked, to=GATE) == [GateAsked(forgotten=True)]
    assert sent(rig.on_message("gateway", order(pump=24)), OrderTaken) == []
    assert len(sent(rig.run(2.5 * ASK_AGAIN_S), GateAsked, to=GATE)) == 2
    assert len(sent(rig.told(), OrderTaken)) == 1
    assert sent(rig.run(30.0), GateAsked) == []


def test_an_order_that_was_released_before_it_began_is_taken_over_from_whoever_has_it() -> None:
    """Whoever took it has answered the gateway, so nobody says it again."""
    rig = GatedRig(shared=True)
    rig.on_message("gateway", order(pump=24))
    rig.told()
    rig.run(rig.now_s + 3 * TURN_S)
    rig.on_message(GATE, HolderReported(OrderHeld("O1", OTHER, 1)))
    claims = sent(rig.run(rig.now_s + PEER_SILENCE_S + 3 * TURN_S), OrderClaimed, to=GATE)
    assert [(each.order, each.epoch) for each in claims][:1] == [("O1", 2)]


def test_nobody_but_the_gate_lets_it_begin() -> None:
    rig = GatedRig()
    rig.on_message("M7", GateReported("", (), more=False, since=1))
    assert sent(rig.on_message("gateway", order(pump=24)), OrderTaken) == []


def test_that_it_has_lost_its_memory_is_told_when_it_begins() -> None:
    rig = GatedRig(life=2, lost="the disk has failed")
    assert len(facts(rig.told(), MemoryLost)) == 1


def test_a_word_to_the_gate_is_repeated_until_that_word_is_answered() -> None:
    rig, goal = making()
    [word] = sent(rig.all, AdmissionAsked, to=GATE)
    assert (word.goal, word.quantity, word.incarnation, word.held) == (goal, 24, 1, 0)
    assert instructed(rig.all, Admit) == []
    assert sent(rig.run(rig.now_s + 1.5 * ASK_AGAIN_S), AdmissionAsked) == [word]
    rig.answered(goal, number=word.number + 7)
    assert set(sent(rig.run(rig.now_s + 1.5 * ASK_AGAIN_S), AdmissionAsked)) == {word}
    rig.answered(goal)
    assert sent(rig.run(rig.now_s + 2.0 * ASK_AGAIN_S), AdmissionAsked) == []


def test_a_machine_hears_that_a_goal_is_its_own_when_the_gate_lets_it_in() -> None:
    rig, goal = making()
    assert sent(rig.all, Confirmed) == []
    assert sent(rig.run(rig.now_s + 10.0), Confirmed) == []
    assert [each.task for each in sent(rig.answered(goal), Confirmed, to="M7")] == [goal]


def test_what_has_arrived_is_told_once_however_often_the_gate_says_it_and_answered_each_time() -> None:
    rig, goal = making()
    rig.answered(goal)
    effects = rig.answered(goal, 5, Brought("ATV1", 5)) + rig.answered(goal, 5, Brought("ATV1", 5))
    assert [each.quantity for each in facts(effects, GoodsDelivered)] == [5]
    assert sent(effects, CountAcknowledged, to=GATE) == [CountAcknowledged(goal, 5)] * 2
    effects = rig.answered(goal, 24, Brought("ATV1", 5), Brought("ATV2", 19))
    assert [each.delivered for each in facts(effects, GoodsDelivered)] == [24]
    assert len(facts(effects, OrderFulfilled)) == 1


def test_a_count_that_was_lost_is_counted_with_the_next_and_each_vehicle_has_its_own() -> None:
    rig, goal = making()
    rig.answered(goal)
    effects = rig.answered(goal, 9, Brought("ATV1", 5), Brought("ATV2", 4))
    assert [each.quantity for each in facts(effects, GoodsDelivered)] == [5, 4]
    last = sent(effects, Confirmed, to="M7")[-1]
    assert last.brought == (Brought("ATV1", 5), Brought("ATV2", 4))


def test_that_a_goal_is_shut_is_said_by_the_next_life_until_the_gate_has_heard_it() -> None:
    rig, goal = making()
    rig.answered(goal)
    effects = rig.on_message("gateway", OrderCancelled(order="O1"))
    assert [(each.goal, each.quantity) for each in sent(effects, AdmissionAsked, to=GATE)] == [(goal, 0)]
    again = rig.next_life()
    assert [(each.goal, each.quantity) for each in sent(again.told(), AdmissionAsked)] == [(goal, 0)]
    again.answered(goal)
    last = again.next_life()
    assert sent(last.told(), AdmissionAsked) == []
    assert not any(isinstance(note, ShutWord) for note in last.memory.values())


def test_a_gate_that_has_lost_its_notes_is_told_again_what_is_open() -> None:
    rig, goal = making()
    rig.answered(goal)
    beat = StationHeartbeat(station=GATE, incarnation=1, seq=1, at_s=0.0)
    rig.on_message(GATE, beat)
    again = StationHeartbeat(station=GATE, incarnation=2, seq=1, at_s=9.0)
    assert sent(rig.on_message(GATE, again), GateAsked, to=GATE) == [GateAsked()]
    assert sent(rig.told(since=1), AdmissionAsked) == []
    rig.on_message(GATE, StationHeartbeat(station=GATE, incarnation=3, seq=1, at_s=9.0))
    assert [each.goal for each in sent(rig.told(since=3), AdmissionAsked)] == [goal]


def test_what_it_holds_is_told_in_parts() -> None:
    rig = holding().next_life(shared=True)
    effects = rig.told(HeldOrder("A1", 1), more=True)
    assert sent(effects, GateAsked, to=GATE) == [GateAsked(after="A1")]
    rig.told(HeldOrder("O1", 1), after="A1")
    assert len(sent(rig.on_message("gateway", order(pump=24)), OrderTaken)) == 1


def test_an_order_is_claimed_until_the_gate_answers_and_an_old_answer_gives_nothing_back() -> None:
    rig = holding()
    assert set(sent(rig.all, OrderClaimed, to=GATE)) == {OrderClaimed("O1", 1)}
    assert sent(rig.run(rig.now_s + 10.0), OrderClaimed) == []
    effects = rig.on_message(GATE, HolderReported(OrderHeld("O1", OTHER, 2)))
    assert sent(effects, HolderAcknowledged, to=GATE) == [HolderAcknowledged("O1", 2)]
    rig.on_message(GATE, HolderReported(OrderHeld("O1", "strategist", 1)))
    assert sent(rig.on_message("gateway", order(pump=24)), OrderTaken) == []


def test_that_an_order_has_ended_is_said_until_the_gate_has_heard_it_also_by_the_next_life() -> None:
    rig = holding()
    rig.on_message("gateway", OrderCancelled(order="O1"))
    ended = OrderClaimed("O1", 1, EVERY_RELEASE)
    assert sent(rig.run(rig.now_s + 1.5 * ASK_AGAIN_S), OrderClaimed, to=GATE) == [ended]
    again = rig.next_life(shared=True)
    assert ended in sent(again.told(HeldOrder("O1", 1)), OrderClaimed, to=GATE)
    again.on_message(GATE, HolderReported(OrderHeld("O1", "strategist", 1, over=EVERY_RELEASE)))
    assert ended not in sent(again.run(again.now_s + 10.0), OrderClaimed)


def test_a_report_with_an_epoch_of_the_far_future_does_not_make_the_gates_own_ones_old_for_ever() -> None:
    """A thief of the gate's certificate has sent it."""
    rig = holding()
    rig.on_message(GATE, HolderReported(OrderHeld("O1", OTHER, COUNT_MAX)))
    effects = rig.on_message(GATE, HolderReported(OrderHeld("O1", "strategist", 1)))
    assert Ignore(OLD) in effects
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    effects = rig.on_message(GATE, HolderReported(OrderHeld("O1", "strategist", 1)))
    assert sent(effects, OrderTaken, to="gateway")


def test_an_end_that_the_gate_has_not_heard_of_is_said_also_when_it_is_asked_who_holds_the_order() -> None:
    rig = holding()
    rig.on_message("gateway", OrderCancelled(order="O1"))
    misled = GoalBrief("O1s1r1-1.1", "pump-p3", 24, 0, 0, held=9, holder=OTHER)
    rig.run(rig.now_s + REPORTED_S + 1.0)
    claims = sent(rig.on_message("M7", mhb("M7", misled, seq=1)), OrderClaimed, to=GATE)
    assert claims in ([], [OrderClaimed("O1", 1, EVERY_RELEASE)])
    assert {each.over for each in sent(rig.run(rig.now_s + 30.0), OrderClaimed)} == {EVERY_RELEASE}


def test_that_an_order_is_made_again_is_said_until_the_gate_has_heard_it() -> None:
    rig = holding()
    rig.on_message("gateway2", OrderCancelled(order="O1"))
    rig.run(rig.now_s + OVERTAKES_S + 0.1)
    effects = rig.on_message("gateway", order(pump=24))
    assert announced(effects)
    anew = OrderClaimed("O1", 1, again=1)
    assert sent(effects, OrderClaimed, to=GATE) == [anew]
    rig.on_message(GATE, HolderReported(OrderHeld("O1", "strategist", 1, over=EVERY_RELEASE)))
    assert anew in sent(rig.run(rig.now_s + 2 * ASK_AGAIN_S), OrderClaimed)
    rig.on_message(GATE, HolderReported(OrderHeld("O1", "strategist", 1)))
    assert sent(rig.run(rig.now_s + 30.0), OrderClaimed) == []
