"""Several strategists: an order is held by one of them, and goes on when that one is silent."""

from __future__ import annotations

import pytest
from bureau import announced, beats, brief, contract, order
from effects import facts, instructed, published, remember, sent
from msgspec import UNSET, UnsetType
from msgspec.structs import replace
from rigs import StrategistRig
from spoken import mhb

from dray.body import Admit, GateState, GoodsArrived, HoldOrder
from dray.body.gate import EVERY_RELEASE
from dray.messages import (
    Event,
    GoalClosed,
    HolderChanged,
    OrderCancelled,
    OrderRevoked,
    OrderTaken,
    RevocationTaken,
    StrategistHeartbeat,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.base import COUNT_MAX
from dray.messages.fact import (
    GoalWithdrawn,
    GoodsDelivered,
    MemoryLost,
    OrderAccepted,
    OrderFulfilled,
    OrderTakenOver,
    TaskClosed,
)
from dray.messages.gate import GoalHeld, GoalOf, OrderHeld
from dray.protocol.runtime.events import Effect
from dray.protocol.strategist.order_holding import REPORTED_S, TURN_S
from dray.protocol.strategist.peers import PEER_SILENCE_S

US, OTHER = "strategist", "strategist2"


class SharedRig(StrategistRig):
    """One of two strategists, with the orders that the gate says it holds."""

    def __init__(self, **options: object) -> None:
        super().__init__(others=(OTHER,), **options)
        self.held: dict[str, int] = {}

    def sense(self) -> GateState:
        return GateState(arrived=dict(self.arrived), held=self.held)

    def grant(
        self, name: str, epoch: int = 1, arrived: tuple[int, ...] = (), *goals: GoalHeld
    ) -> list[Effect]:
        """The gate lets it hold an order."""
        self.held[name] = epoch
        return self.report(OrderHeld(name, US, epoch, arrived, goals))

    def other_says(self, orders: int = 0) -> list[Effect]:
        """The other one is there."""
        seq = int(self.now_s * 10) + 1
        return self.on_message(OTHER, StrategistHeartbeat(OTHER, 1, seq, self.now_s, orders))


def begun(**options: object) -> SharedRig:
    rig = SharedRig(**options)
    rig.start()
    return rig


def open_goal(
    name: str = "O1s2r1-1.1", machine: str = "M7", admitted: int = 24, arrived: int = 5
) -> GoalHeld:
    return GoalHeld(name, GoalOf("O1", 0, machine, 1), admitted, arrived)


def asking() -> SharedRig:
    """An order of 24 pumps was heard, and the gate is asked for it."""
    rig = begun()
    rig.on_message("gateway", order(pump=24))
    rig.run(TURN_S)
    return rig


def held_by_the_other(*, over: int = 0) -> SharedRig:
    """An order of 24 pumps is held by the other one."""
    rig = begun()
    rig.other_says()
    rig.on_message("gateway", order(pump=24))
    rig.run(TURN_S)
    rig.report(OrderHeld("O1", OTHER, 1, over=over))
    return rig


def orphaned() -> SharedRig:
    """The other one, who holds it, is silent by now."""
    rig = held_by_the_other()
    rig.run(PEER_SILENCE_S + 3 * TURN_S)
    return rig


def again(rig: SharedRig, **held: int) -> SharedRig:
    """It is started again, and the gate says what it holds."""
    reborn = SharedRig(memory=remember(rig.memory, rig.all), incarnation=2)
    reborn.arrived, reborn.now_s, reborn.held = rig.arrived, rig.now_s, held
    reborn.start()
    return reborn


def test_an_order_is_taken_when_the_gate_lets_the_strategist_hold_it() -> None:
    rig = begun()
    rig.other_says(orders=3)
    effects = rig.on_message("gateway", order(pump=24)) + rig.run(0.0)
    assert instructed(effects, HoldOrder) == [HoldOrder("O1", 1)]
    assert not sent(effects, OrderTaken)
    assert not published(effects, TaskAnnounced)
    effects = rig.grant("O1")
    assert sent(effects, OrderTaken, to="gateway")
    assert [fact.order for fact in facts(effects, OrderAccepted)] == ["O1"]
    [(goal, _, _)] = announced(effects)
    assert goal == "O1s1r1-1.1"


def test_who_has_more_in_work_claims_an_order_a_turn_later() -> None:
    rig = begun()
    rig.other_says()
    rig.on_message("gateway", order("O0", pump=24))
    rig.run(TURN_S)
    rig.grant("O0")
    effects = rig.on_message("gateway", order(pump=24)) + rig.run(rig.now_s)
    assert not instructed(effects, HoldOrder)
    assert instructed(rig.run(rig.now_s + TURN_S), HoldOrder) == [HoldOrder("O1", 1)]


def test_an_order_that_another_one_holds_is_left_to_that_one() -> None:
    rig = held_by_the_other()
    heard = len(rig.all)
    for message in (order(pump=24), OrderRevoked(order="O1", release=1), OrderCancelled(order="O1")):
        rig.other_says()
        rig.on_message("gateway", message)
        rig.run(rig.now_s + 3 * TURN_S)
    effects = rig.all[heard:]
    assert not instructed(effects, HoldOrder)
    assert not [effect for effect in effects if sent([effect], OrderTaken) or sent([effect], RevocationTaken)]


def test_the_orders_of_a_silent_strategist_are_claimed_with_the_next_epoch() -> None:
    rig = orphaned()
    assert instructed(rig.all, HoldOrder)[-1] == HoldOrder("O1", 2)


def test_the_orders_of_one_that_has_lost_its_notes_are_claimed_though_it_lives() -> None:
    rig = held_by_the_other()
    rig.other_says()
    rig.on_message(OTHER, Event(OTHER, 2, 1, rig.now_s, MemoryLost("lost")))
    effects = rig.run(rig.now_s + 2 * TURN_S)
    assert instructed(effects, HoldOrder) == [HoldOrder("O1", 2)]
    assert facts(rig.grant("O1", 2, (5,), open_goal()), OrderTakenOver)
    # What this one holds itself nobody's word makes free.
    rig.on_message(OTHER, Event(OTHER, 3, 1, rig.now_s, MemoryLost("lost")))
    assert not instructed(rig.run(rig.now_s + 2 * TURN_S), HoldOrder)


def test_machines_go_on_with_the_goals_of_an_order_that_is_taken_over() -> None:
    rig = orphaned()
    effects = rig.grant("O1", 2, (5,), open_goal())
    assert announced(effects) == []
    assert facts(effects, OrderTakenOver) == [OrderTakenOver("O1", 2, ("O1s2r1-1.1",))]
    effects = rig.on_message("M7", mhb("M7", brief("O1s2r1-1.1"), seq=1))
    assert sent(effects, HolderChanged, to="M7") == [HolderChanged("O1", 2)]
    assert not sent(effects, Withdrawn)
    rig.arrived["O1s2r1-1.1"] = 5
    effects = rig.arrive("O1s2r1-1.1", 19)
    assert sent(effects, GoalClosed, to="M7")
    assert [fact.order for fact in facts(effects, OrderFulfilled)] == ["O1"]


@pytest.mark.parametrize(("told", "by"), [(2, OTHER), (COUNT_MAX, OTHER), (COUNT_MAX, UNSET)])
def test_a_machine_that_obeys_another_one_with_a_later_epoch_is_told_once_the_gate_has_said_who_holds_the_order(
    told: int, by: str | UnsetType
) -> None:
    """A thief of a strategist's certificate has told the machine; or the gate has another holder, and its word is under way."""
    rig = orphaned()
    rig.grant("O1", 2, (5,), open_goal())
    rig.run(rig.now_s + REPORTED_S + 1.0)
    misled = replace(brief("O1s2r1-1.1"), held=told, holder=by)
    effects = rig.on_message("M7", mhb("M7", misled, seq=1))
    assert not sent(effects, HolderChanged)
    assert instructed(effects, HoldOrder) == [HoldOrder("O1", 2)]
    rig.report(OrderHeld("O1", US, 2, (5,), (open_goal(),)))
    effects = rig.on_message("M7", mhb("M7", misled, seq=2))
    assert sent(effects, HolderChanged, to="M7") == [HolderChanged("O1", 2)]
    effects = rig.on_message("M7", mhb("M7", replace(misled, held=2, holder=US), seq=3))
    assert not sent(effects, HolderChanged)


def test_what_came_while_nobody_held_the_order_is_told_by_who_takes_it_over() -> None:
    rig = orphaned()
    rig.held["O1"] = 2
    over = GoalHeld("O1s2r1-1.2", GoalOf("O1", 0, "M8", 1), 7, 7)
    effects = rig.report(OrderHeld("O1", US, 2, (9,), (open_goal(admitted=12, arrived=2),), done=(over,)))
    told = {fact.goal: fact.delivered for fact in facts(effects, GoodsDelivered)}
    assert told == {"O1s2r1-1.1": 2, "O1s2r1-1.2": 7}
    ended = orphaned()
    ended.held["O1"] = 2
    assert not facts(ended.report(OrderHeld("O1", US, 2, (7,), over=1, done=(over,))), GoodsDelivered)


def test_only_what_no_goal_is_left_for_is_put_up_anew() -> None:
    rig = orphaned()
    effects = rig.grant("O1", 2, (9,), open_goal(admitted=12, arrived=2))
    [(goal, _, quantity)] = announced(effects)
    # Seven have arrived of goals that are over, and twelve are being made.
    assert (goal, quantity) == ("O1s1r1-1.1", 24 - 7 - 12)


def test_an_order_of_which_all_has_arrived_is_fulfilled_at_once() -> None:
    rig = orphaned()
    effects = rig.grant("O1", 2, (24,))
    assert announced(effects) == []
    assert [fact.order for fact in facts(effects, OrderFulfilled)] == ["O1"]
    assert sent(rig.on_message("gateway", order(pump=24)), OrderTaken)[0].fulfilled


def test_what_is_told_of_goals_says_with_which_epoch_their_order_is_held() -> None:
    fresh = asking()
    assert [fact.held for fact in facts(fresh.grant("O1"), OrderAccepted)] == [1]
    rig = orphaned()
    rig.grant("O1", 2, (5,), open_goal())
    rig.on_message("gateway", OrderRevoked(order="O1", release=1))
    effects = rig.report(GoodsArrived("O1s2r1-1.1", arrived=5, admitted=0))
    assert [fact.held for fact in facts(effects, GoalWithdrawn)] == [2]


def test_a_goal_that_no_machine_names_is_made_again_behind_a_shut_gate() -> None:
    rig = orphaned()
    rig.grant("O1", 2, (5,), open_goal())
    rig.arrived["O1s2r1-1.1"] = 5
    beats(rig, rig.now_s + 30.0, "M7", "M8")
    assert rig.admitted("O1s2r1-1.1") == 0
    effects = rig.gate_answers("O1s2r1-1.1")
    [(_, _, quantity)] = announced(effects)
    assert quantity == 19


def test_what_has_ended_with_another_one_is_not_claimed() -> None:
    rig = held_by_the_other()
    rig.on_message(OTHER, Event(OTHER, 1, 1, rig.now_s, OrderFulfilled("O1")))
    rig.run(PEER_SILENCE_S + 3 * TURN_S)
    assert instructed(rig.all, HoldOrder)[-1] == HoldOrder("O1", 1)


def test_what_has_ended_by_the_gate_s_word_is_not_claimed() -> None:
    rig = held_by_the_other(over=1)
    rig.run(PEER_SILENCE_S + 3 * TURN_S)
    assert instructed(rig.all, HoldOrder)[-1] == HoldOrder("O1", 1)


def test_of_an_order_that_has_ended_nothing_is_made_by_who_takes_it_over() -> None:
    rig = orphaned()
    effects = rig.report(OrderHeld("O1", US, 2, (5,), (), 1))
    assert announced(effects + rig.run(rig.now_s + 60.0)) == []
    effects = rig.on_message("gateway", OrderRevoked(order="O1", release=1))
    assert sent(effects, RevocationTaken) == [RevocationTaken("O1", 1, (19,))]


def test_an_order_that_was_taken_back_may_be_released_again_to_who_has_taken_it_over() -> None:
    rig = orphaned()
    rig.report(OrderHeld("O1", US, 2, (5,), (), 1))
    again = replace(order(pump=19), release=2)
    effects = rig.on_message("gateway", again) + rig.run(rig.now_s + TURN_S)
    assert [quantity for _, _, quantity in announced(effects)] == [19]


def test_the_gate_is_told_that_an_order_has_ended() -> None:
    rig, goal = holding()
    effects = rig.on_message("gateway", OrderRevoked(order="O1", release=1)) + rig.gate_answers(goal)
    assert instructed(effects, HoldOrder) == [HoldOrder("O1", 1, over=1)]
    rig, goal = holding()
    assert instructed(rig.arrive(goal, 24), HoldOrder) == [HoldOrder("O1", 1, over=EVERY_RELEASE)]
    rig, goal = holding()
    effects = rig.on_message("gateway", OrderCancelled(order="O1"))
    assert instructed(effects, HoldOrder) == [HoldOrder("O1", 1, over=EVERY_RELEASE)]


def holding() -> tuple[SharedRig, str]:
    """It holds an order, whose goal M7 makes."""
    rig = asking()
    rig.grant("O1")
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    return rig, goal


def test_the_gate_is_told_what_a_goal_is_for_and_who_makes_it() -> None:
    rig, goal = holding()
    assert instructed(rig.all, Admit) == [Admit(goal, 24, GoalOf("O1", 0, "M7", 1))]


def test_an_order_that_another_one_has_taken_over_is_given_up() -> None:
    rig, goal = holding()
    effects = rig.report(OrderHeld("O1", OTHER, 2))
    effects += beats(rig, rig.now_s + 40.0, "M8")
    effects += rig.on_message("M7", mhb("M7", brief(goal), seq=9000))
    assert not instructed(effects, Admit)
    assert not [effect for effect in effects if sent([effect], Withdrawn) or facts([effect], TaskClosed)]


def test_an_auction_of_an_order_that_is_given_up_ends() -> None:
    rig = asking()
    rig.grant("O1")
    effects = rig.report(OrderHeld("O1", OTHER, 2)) + rig.run(rig.now_s + 60.0)
    assert [fact.outcome for fact in facts(effects, TaskClosed)] == ["withdrawn"]
    assert not published(effects, TaskAnnounced)


def test_who_comes_back_goes_on_with_what_it_holds_still() -> None:
    rig, goal = holding()
    reborn = again(rig, O1=1)
    assert not instructed(reborn.all, HoldOrder)
    assert reborn.admitted(goal) == 24
    assert [fact.order for fact in facts(reborn.arrive(goal, 24), OrderFulfilled)] == ["O1"]


def test_who_comes_back_gives_up_what_another_one_holds_by_now() -> None:
    rig, goal = holding()
    reborn = again(rig)
    assert not instructed(reborn.all, Admit)
    effects = reborn.on_message("M7", mhb("M7", brief(goal), seq=9000))
    assert not sent(effects, Withdrawn)
    assert not sent(effects, HolderChanged)


def test_an_order_that_was_granted_to_an_earlier_life_is_asked_for_again() -> None:
    rig = asking()
    reborn = again(rig, O1=1)
    assert instructed(reborn.all, HoldOrder) == [HoldOrder("O1", 1)]
    assert sent(reborn.grant("O1"), OrderTaken, to="gateway")
    assert len(announced(reborn.all)) == 1


def test_what_is_noted_of_an_order_outlives_the_strategist() -> None:
    rig = held_by_the_other()
    reborn = again(rig)
    reborn.run(reborn.now_s + PEER_SILENCE_S + 3 * TURN_S)
    assert instructed(reborn.all, HoldOrder)[-1] == HoldOrder("O1", 2)


def test_an_order_that_was_taken_over_is_taken_back_with_what_the_gate_has_counted() -> None:
    rig = orphaned()
    rig.grant("O1", 2, (5,), open_goal())
    rig.arrived["O1s2r1-1.1"] = 5
    effects = rig.on_message("gateway", OrderRevoked(order="O1", release=1))
    assert rig.admitted("O1s2r1-1.1") == 0
    effects += rig.gate_answers("O1s2r1-1.1")
    assert sent(effects, RevocationTaken) == [RevocationTaken("O1", 1, (19,))]


def test_a_strategist_that_leaves_claims_nothing_and_is_missed() -> None:
    rig = begun()
    rig.other_says()
    rig.leave()
    effects = rig.on_message("gateway", order(pump=24)) + rig.run(PEER_SILENCE_S + 3 * TURN_S)
    assert not instructed(effects, HoldOrder)
    assert not published(effects, StrategistHeartbeat)
