"""The gate's agent: what has arrived is told once, what is let in follows the newest word, and an order is held by one strategist."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import instructed, remember, sent
from rigs import Rig

from dray.body import Admit, GateState, GoodsArrived
from dray.body.gate import EVERY_RELEASE
from dray.memory import Memory
from dray.messages import (
    AdmissionAsked,
    Brought,
    CountAcknowledged,
    GateAsked,
    GateReported,
    GoodsCounted,
    HolderAcknowledged,
    HolderReported,
    Message,
    OrderClaimed,
    StationHeartbeat,
)
from dray.messages.base import COUNT_MAX
from dray.messages.gate import GoalHeld, GoalOf, HeldOrder, OrderHeld
from dray.messages.overtaken import OVERTAKES_S
from dray.protocol.gate.gate import DeliveryGate
from dray.protocol.runtime.events import Effect
from dray.protocol.runtime.retransmission import ASK_AGAIN_S

ONE, OTHER = "strategist", "strategist2"

OF = GoalOf("O1", 1, "M1", 3)


class GateRig(Rig):
    """A gate's agent, and a gate that obeys at once."""

    def __init__(
        self, *, memory: Memory | None = None, body: GateRig | None = None, life: int = 1, kept: int = 99
    ) -> None:
        super().__init__(DeliveryGate(PLANT, incarnation=life, kept=kept))
        self.memory = memory or {}
        self.arrived: dict[str, int] = {} if body is None else body.arrived
        self.admitted: dict[str, int] = {} if body is None else body.admitted
        self.start()

    def sense(self) -> GateState:
        return GateState(arrived=dict(self.arrived))

    def obey(self, effects: list[Effect]) -> list[Effect]:
        for admit in instructed(effects, Admit):
            self.admitted[admit.goal] = admit.quantity
            arrived = self.arrived.setdefault(admit.goal, 0)
            effects = effects + self.report(GoodsArrived(admit.goal, arrived, admit.quantity))
        return effects

    def say(self, message: Message, sender: str = ONE) -> list[Effect]:
        """What comes of a message, with what the gate does about it."""
        return self.obey(self.on_message(sender, message))

    def enter(self, goal: str, pieces: int, vehicle: str = "ATV1", *, told: bool = True) -> list[Effect]:
        """Pieces get in, and the agent hears of it unless it is away."""
        total = self.arrived[goal] = self.arrived[goal] + pieces
        return self.report(GoodsArrived(goal, total, self.admitted[goal], vehicle)) if told else []

    def next_life(self) -> GateRig:
        """It is killed, and starts again with what it has noted."""
        rig = GateRig(memory=remember(self.memory, self.all), body=self, life=self.agent.incarnation + 1)
        rig.obey(list(rig.all))
        return rig


def asked(
    goal: str, quantity: int, number: int = 1, *, life: int = 1, held: int = 0, of: GoalOf | None = None
) -> AdmissionAsked:
    return AdmissionAsked(goal, quantity, life, number, of, held)


def counted(effects: list[Effect], to: str = ONE) -> list[tuple[str, int, int]]:
    return [(each.goal, each.arrived, each.admitted) for each in sent(effects, GoodsCounted, to=to)]


def test_what_is_asked_for_is_let_in_and_answered_with_the_count_and_the_number_of_the_word() -> None:
    rig = GateRig()
    [told] = sent(rig.say(asked("G1", 5, 7)), GoodsCounted, to=ONE)
    assert (told.arrived, told.admitted, told.incarnation, told.number) == (0, 5, 1, 7)
    assert rig.admitted == {"G1": 5}


def test_an_arrival_is_told_until_it_was_heard_and_then_no_more() -> None:
    rig = GateRig()
    rig.say(asked("G1", 5))
    [told] = sent(rig.enter("G1", 2), GoodsCounted, to=ONE)
    assert told.brought == (Brought("ATV1", 2),)
    assert counted(rig.run(rig.now_s + 2.5 * ASK_AGAIN_S)) == [("G1", 2, 5)] * 2
    rig.say(CountAcknowledged("G1", 2))
    assert counted(rig.run(rig.now_s + 5 * ASK_AGAIN_S)) == []
    [told] = sent(rig.enter("G1", 3, "ATV2"), GoodsCounted, to=ONE)
    assert told.brought == (Brought("ATV1", 2), Brought("ATV2", 3))


def test_an_old_word_about_a_goal_opens_nothing() -> None:
    rig = GateRig()
    rig.say(asked("G1", 5, 1))
    rig.say(asked("G1", 0, 2))
    assert instructed(rig.say(asked("G1", 5, 1)), Admit) == []
    assert rig.admitted == {"G1": 0}
    rig.say(asked("G1", 5, 1, life=2))
    assert rig.admitted == {"G1": 5}


def test_a_count_before_the_gate_has_obeyed_answers_no_word() -> None:
    rig = GateRig()
    rig.say(asked("G1", 5, 1))
    rig.on_message(ONE, asked("G1", 0, 2))
    [told] = sent(rig.enter("G1", 2), GoodsCounted, to=ONE)
    assert (told.arrived, told.admitted, told.number) == (2, 5, 0)


def test_what_came_while_it_was_away_is_counted_once_when_it_is_back() -> None:
    rig = GateRig()
    rig.say(asked("G1", 5))
    rig.enter("G1", 2)
    rig.say(CountAcknowledged("G1", 2))
    rig.enter("G1", 1, told=False)
    rig = rig.next_life()
    assert counted(rig.all)[-1] == ("G1", 3, 5)
    rig.say(CountAcknowledged("G1", 3))
    rig = rig.next_life()
    assert counted(rig.run(5 * ASK_AGAIN_S)) == []


def test_what_was_not_heard_is_told_again_by_the_next_life() -> None:
    rig = GateRig()
    rig.say(asked("G1", 2))
    rig.enter("G1", 2)
    assert ("G1", 2, 2) in counted(rig.next_life().all)


def test_what_the_gate_may_not_have_heard_is_said_to_it_again_by_the_next_life_and_nothing_is_opened_twice() -> (
    None
):
    rig = GateRig()
    rig.say(asked("G1", 2))
    rig.enter("G1", 2)
    rig.say(asked("G2", 5))
    rig.on_message(ONE, asked("G2", 0, 2))  # and it is killed before the gate has heard that.
    rig = rig.next_life()
    assert instructed(rig.all, Admit) == [Admit("G2", 0)]
    assert rig.admitted["G2"] == 0


def test_an_order_is_held_by_who_asks_first_over_the_gates_lives() -> None:
    rig = GateRig()
    assert sent(rig.say(OrderClaimed("O1", 1)), HolderReported) == [HolderReported(OrderHeld("O1", ONE, 1))]
    rig = rig.next_life()
    assert sent(rig.say(OrderClaimed("O1", 1), OTHER), HolderReported) == [
        HolderReported(OrderHeld("O1", ONE, 1))
    ]
    told = sent(rig.say(GateAsked()), GateReported)
    assert [each.held for each in told] == [(HeldOrder("O1", 1),)]
    assert [each.held for each in sent(rig.say(GateAsked(), OTHER), GateReported)] == [()]


def test_who_has_lost_an_order_is_told_until_it_has_heard() -> None:
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    effects = rig.say(OrderClaimed("O1", 2), OTHER)
    lost = HolderReported(OrderHeld("O1", OTHER, 2))
    assert sent(effects, HolderReported, to=ONE) == sent(effects, HolderReported, to=OTHER) == [lost]
    assert sent(rig.run(rig.now_s + 1.5 * ASK_AGAIN_S), HolderReported, to=ONE) == [lost]
    rig = rig.next_life()
    assert sent(rig.all, HolderReported, to=ONE) == [lost]
    rig.say(HolderAcknowledged("O1", 2))
    assert sent(rig.run(5 * ASK_AGAIN_S), HolderReported) == []


def test_who_takes_an_order_over_hears_what_has_arrived_and_what_is_open() -> None:
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    rig.say(asked("G1", 5, held=1, of=OF))
    rig.say(asked("G2", 4, held=1, of=OF))
    rig.enter("G1", 5)
    rig.enter("G2", 3)
    [told] = sent(rig.say(OrderClaimed("O1", 2), OTHER), HolderReported, to=OTHER)
    open_, done = GoalHeld("G2", OF, 4, 3), GoalHeld("G1", OF, 5, 5)
    assert told == HolderReported(OrderHeld("O1", OTHER, 2, (0, 8), (open_,), done=(done,)))
    # What arrives from now on is for the new one.
    assert counted(rig.enter("G2", 1), OTHER) == [("G2", 4, 4)]
    assert counted(rig.run(rig.now_s + 2 * ASK_AGAIN_S), ONE) == []


def test_an_order_is_handed_over_when_the_count_of_each_shut_goal_is_final() -> None:
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    rig.say(asked("G1", 5, held=1, of=OF))
    rig.on_message(ONE, asked("G1", 0, 2, held=1))  # and its body has not confirmed that yet.
    rig.enter("G1", 3)
    for claimed, by in ((OrderClaimed("O1", 2), OTHER), (OrderClaimed("O1", 1), ONE)):
        effects = rig.on_message(by, claimed)
        assert sent(effects, HolderReported) == [], "nor to a holder that has lost its journal"
        assert instructed(effects, Admit) == [Admit("G1", 0)], "its body is told again"
    rig.obey(effects)
    [told] = sent(rig.say(OrderClaimed("O1", 2), OTHER), HolderReported, to=OTHER)
    done = GoalHeld("G1", OF, 0, 3)
    assert told == HolderReported(OrderHeld("O1", OTHER, 2, (0, 3), done=(done,)))


def test_that_an_order_has_ended_is_answered_while_a_goal_of_it_is_being_shut() -> None:
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    rig.say(asked("G1", 5, held=1, of=OF))
    rig.on_message(ONE, asked("G1", 0, 2, held=1))
    [told] = sent(rig.say(OrderClaimed("O1", 1, over=1)), HolderReported, to=ONE)
    assert told.held.over == 1


def test_a_goal_is_let_in_on_the_word_of_who_holds_its_order_alone() -> None:
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    rig.say(asked("G1", 5, held=1, of=OF))
    rig.say(OrderClaimed("O1", 2), OTHER)
    lost = [HolderReported(OrderHeld("O1", OTHER, 2))]
    for word in (asked("G1", 0, 2, held=1), asked("G2", 5, 3, held=1, of=OF)):
        effects = rig.say(word)
        assert sent(effects, HolderReported, to=ONE) == lost
        assert instructed(effects, Admit) == []


def test_a_word_from_before_an_order_was_lost_and_taken_again_opens_nothing() -> None:
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    late = asked("G1", 5, 1, held=1, of=OF)
    rig.say(late)
    rig.say(OrderClaimed("O1", 2), OTHER)
    rig.say(asked("G1", 0, 1, held=2), OTHER)
    rig.say(OrderClaimed("O1", 3))
    assert instructed(rig.say(late), Admit) == []
    assert rig.admitted == {"G1": 0}


def test_that_an_order_has_ended_is_told_to_whoever_takes_it() -> None:
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    rig.say(OrderClaimed("O1", 1, over=EVERY_RELEASE))
    [told] = sent(rig.next_life().say(OrderClaimed("O1", 2), OTHER), HolderReported, to=OTHER)
    assert told.held.over == EVERY_RELEASE
    assert [each.held for each in sent(rig.say(GateAsked()), GateReported)] == [()]


def test_a_strategist_that_remembers_nothing_is_answered_when_the_gate_is_shut_for_it() -> None:
    rig = GateRig()
    rig.say(asked("G1", 5, 1))
    rig.say(asked("G2", 2, 2))
    rig.enter("G2", 2)
    effects = rig.on_message(ONE, GateAsked(forgotten=True))
    assert sent(effects, GateReported) == []
    assert instructed(effects, Admit) == [Admit("G1", 0)]
    rig.obey(effects)
    assert len(sent(rig.say(GateAsked(forgotten=True)), GateReported)) == 1
    # A word of the life that is forgotten, which comes late, opens nothing.
    assert instructed(rig.say(asked("G1", 5, 1)), Admit) == []


def test_a_full_memory_forgets_what_is_in_and_heard_before_what_is_open() -> None:
    rig = GateRig(kept=2)
    rig.say(asked("G1", 5))
    rig.say(asked("G2", 1, 2))
    rig.enter("G2", 1)
    rig.say(CountAcknowledged("G2", 1))
    rig.say(asked("G3", 5, 3))
    assert counted(rig.enter("G1", 1)) == [("G1", 1, 5)]
    assert counted(rig.enter("G2", 1)) == []


def test_it_says_that_it_is_there() -> None:
    rig = GateRig()
    rig.run(12.0)
    [first, *_] = rig.heartbeats(StationHeartbeat)
    assert (first.station, first.incarnation, first.stocks) == ("gate", 1, ())
    assert len(rig.heartbeats(StationHeartbeat)) >= 3


@pytest.mark.parametrize("known", [True, False], ids=["of a known order", "of one that is new"])
def test_whatever_epoch_a_thief_of_a_strategists_certificate_claims_another_one_can_take_the_order_over(
    known: bool,
) -> None:
    rig = GateRig()
    if known:
        rig.say(OrderClaimed("O1", 1), OTHER)
    rig.say(OrderClaimed("O1", COUNT_MAX))
    [told] = sent(rig.say(OrderClaimed("O1", COUNT_MAX), OTHER), HolderReported, to=OTHER)
    if told.held.holder != OTHER:
        [told] = sent(rig.say(OrderClaimed("O1", told.held.epoch + 1), OTHER), HolderReported, to=OTHER)
    assert told.held.holder == OTHER
    assert told.held.epoch < COUNT_MAX


@pytest.mark.parametrize("life", [1, 2], ids=["the same life", "the next life"])
@pytest.mark.parametrize("restarts", [False, True], ids=["this gate", "the gate's next life"])
def test_a_request_with_a_number_of_the_far_future_does_not_shut_out_later_ones_for_ever(
    life: int, restarts: bool
) -> None:
    """A thief of the strategist's certificate has sent it."""
    rig = GateRig()
    rig.say(asked("G1", 5))
    rig.say(asked("G1", 9, COUNT_MAX, life=COUNT_MAX))
    rig.say(asked("G1", 6, 2, life=life))
    assert rig.admitted["G1"] == 9, "perhaps it came late"
    if restarts:
        rig = rig.next_life()
    rig.run(rig.now_s + OVERTAKES_S + 1.0)
    rig.say(asked("G1", 7, 3, life=life))
    assert rig.admitted["G1"] == 7


def test_an_order_that_is_made_again_is_over_for_no_later_holder() -> None:
    """A thief of a gateway's certificate had cancelled it."""
    rig = GateRig()
    rig.say(OrderClaimed("O1", 1))
    rig.say(OrderClaimed("O1", 1, over=EVERY_RELEASE))
    rig.say(OrderClaimed("O1", 1, again=2), OTHER)
    [told] = sent(rig.say(OrderClaimed("O1", 1)), HolderReported)
    assert told.held.over == EVERY_RELEASE, "its holder alone says so"
    [told] = sent(rig.say(OrderClaimed("O1", 1, again=2)), HolderReported)
    assert told.held.over == 1
    [told] = sent(rig.say(OrderClaimed("O1", 2), OTHER), HolderReported, to=OTHER)
    assert (told.held.holder, told.held.over) == (OTHER, 1)
