"""A production machine bids for goals, takes them, and gives them back."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import pytest
from defaults import KEYS
from effects import deeds, facts, instructed, listening, published, sent
from m7 import FULL, NO_HOUSINGS, RELEASE, counted, handover, incoming, m7, outgoing, status, transports
from msgspec.structs import replace
from rigs import MachineRig
from spoken import announcement, production, transport

from dray.body import Broken, OpenDock, StartCycle
from dray.messages import (
    Accepted,
    Award,
    Bid,
    Confirmed,
    Declined,
    Docked,
    GoalClosed,
    MachineHeartbeat,
    MachineStatus,
    Message,
    Reason,
    Refusal,
    Release,
    Role,
    TaskAnnounced,
    Transport,
    Withdrawn,
)
from dray.messages.fact import BidRefused, ContractEnded, ContractTaken, TaskClosed
from dray.protocol.contract_net.parties import NO_PARTY
from dray.protocol.runtime.events import Ignore
from dray.protocol.runtime.retransmission import ASK_AGAIN_S


def test_a_machine_listens_for_the_goals_it_can_make() -> None:
    rig = MachineRig("M8")
    assert listening(rig.start()) == {
        KEYS.goals("gear-unit-g2"),
        KEYS.goals("pump-p3"),
        KEYS.goals("M8"),
        KEYS.all_free,
        KEYS.closures,
        KEYS.all_breakdowns,
        KEYS.all_operator_heartbeats,
    }


def test_a_machine_bids_for_a_goal_with_the_parts_of_its_price() -> None:
    rig = m7()
    effects = rig.on_message("S", announcement(task="G1", coordinator="STRATEGIST", work=production()))
    [bid_] = sent(effects, Bid, to="STRATEGIST")
    assert bid_.cost.total_s == 24 * 50.0
    assert bid_.finish_s == rig.now_s + 24 * 50.0


def test_a_machine_with_a_queue_is_dearer() -> None:
    ask = announcement(task="G9", coordinator="STRATEGIST", work=production())
    idle_s, busy_s = (sent(rig.on_message("S", ask), Bid)[0].cost.total_s for rig in (m7(), m7(goal=24)))
    assert busy_s == idle_s + 24 * 50.0


def test_transports_and_other_products_are_not_bid_for() -> None:
    rig = m7()
    assert rig.on_message("M8", announcement()) == []
    other = production(product="gear-unit-g1")
    assert rig.on_message("S", announcement(coordinator="STRATEGIST", work=other)) == []


@pytest.mark.parametrize("product", ["gear-unit-g1", "nonsense"])
def test_an_award_of_what_the_machine_does_not_make_is_declined(product: str) -> None:
    rig = m7()
    [declined] = sent(rig.award_goal("G1", production(product=product)), Declined, to="STRATEGIST")
    assert (declined.task, declined.reason) == ("G1", Refusal.ABILITY)
    assert facts(rig.all, ContractTaken) == []


def test_a_transport_is_not_for_machines() -> None:
    rig = m7()
    carrying = Award(task="T", epoch=1, role=Role.PRIMARY, work=transport(), deadline_s=1.0, number=3)
    [declined] = sent(rig.on_message("M8", carrying), Declined, to="M8")
    assert (declined.reason, declined.number) == (Refusal.ABILITY, 3)


def test_a_broken_machine_refuses_with_its_reason() -> None:
    rig = m7()
    rig.report(Broken(reason="oil"))
    ask = announcement(task="G1", coordinator="STRATEGIST", work=production())
    [refused] = facts(rig.on_message("S", ask), BidRefused)
    assert (refused.reason, refused.detail) == (Refusal.NOT_FIT, "oil")
    [declined] = sent(rig.take_goal("G1", production()), Declined)
    assert declined.reason is Refusal.NOT_FIT


def test_a_goal_that_is_awarded_is_accepted_with_what_was_promised() -> None:
    rig = m7()
    rig.on_message("S", announcement(task="G1", coordinator="STRATEGIST", work=production()))
    rig.now_s = 2.0
    effects = rig.take_goal("G1", production())
    [answer] = sent(effects, Accepted, to="STRATEGIST")
    assert answer.finish_s == 24 * 50.0
    assert len(facts(effects, ContractTaken)) == 1


def test_a_goal_that_is_awarded_twice_is_taken_once() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    effects = rig.take_goal("G1", production(quantity=24))
    assert sent(effects, Accepted, to="STRATEGIST")
    assert facts(effects, ContractTaken) == []
    rig.run(5.0)
    [brief] = rig.heartbeats(MachineHeartbeat)[-1].goals
    assert (brief.goal, brief.quantity) == ("G1", 24)
    assert incoming(rig.all) == [("housing", 24)]


def test_nothing_of_a_goal_is_begun_before_it_is_confirmed() -> None:
    rig = m7(NO_HOUSINGS | {"housing": 2})
    rig.award_goal("G1", production())
    rig.run(60.0)
    assert instructed(rig.all, StartCycle) == []
    assert transports(rig.all) == []
    assert status(rig) is MachineStatus.IDLE
    gaps_s = [b.at_s - a.at_s for a, b in pairwise(rig.heartbeats(MachineHeartbeat)[-5:])]
    assert gaps_s == pytest.approx([1.0] * 4)
    assert [brief.goal for brief in rig.heartbeats(MachineHeartbeat)[-1].goals] == ["G1"]
    effects = rig.confirm_goal("G1")
    assert instructed(effects, StartCycle)
    assert incoming(effects) == [("housing", 24)]


def test_an_acceptance_is_repeated_until_it_is_confirmed() -> None:
    rig = m7()
    [first] = sent(rig.award_goal("G1", production()), Accepted)
    repeated = sent(rig.run(4 * ASK_AGAIN_S), Accepted, to="STRATEGIST")
    assert [replace(each, at_s=first.at_s) for each in repeated] == [first] * 4
    rig.confirm_goal("G1")
    assert sent(rig.run(rig.now_s + 60.0), Accepted) == []


def test_an_acceptance_is_repeated_no_more_after_a_release() -> None:
    rig = m7()
    rig.award_goal("G1", production())
    rig.on_message(
        "STRATEGIST", Release(task="G1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1)
    )
    assert sent(rig.run(60.0), Accepted) == []
    assert rig.heartbeats(MachineHeartbeat)[-1].goals == ()
    assert deeds(rig.confirm_goal("G1")) == []
    assert not rig.is_cycling


def test_confirming_twice_is_harmless() -> None:
    rig = m7(goal=24)
    assert deeds(rig.confirm_goal("G1")) == []
    assert len(instructed(rig.all, StartCycle)) == 1


def test_a_doubled_award_is_answered_until_it_is_confirmed_again_and_no_longer() -> None:
    rig = m7(goal=24)
    rig.award_goal("G1", production())
    assert len(sent(rig.run(ASK_AGAIN_S), Accepted)) == 1
    rig.confirm_goal("G1")
    assert sent(rig.run(rig.now_s + 60.0), Accepted) == []


def test_the_answer_carries_the_number_of_the_award_that_it_answers() -> None:
    rig = m7()
    given = Award(task="G1", epoch=1, role=Role.PRIMARY, work=production(), deadline_s=3600.0, number=2)
    [first] = sent(rig.on_message("STRATEGIST", given), Accepted)
    [second] = sent(rig.on_message("STRATEGIST", msgspec.structs.replace(given, number=5)), Accepted)
    assert (first.number, second.number) == (2, 5)
    assert {answer.number for answer in sent(rig.run(10.0), Accepted)} == {5}


def test_a_goal_whose_promise_has_become_empty_is_declined() -> None:
    rig = m7()
    rig.on_message("S", announcement(task="G1", coordinator="STRATEGIST", work=production()))
    rig.take_goal("G2", production(order="O2"))
    [declined] = sent(rig.take_goal("G1", production()), Declined, to="STRATEGIST")
    assert declined.reason is Refusal.BUSY
    assert declined.task == "G1"


WITHDRAWN = Withdrawn(task="G1", epoch=1, reason=Reason.NOT_NEEDED)


@pytest.mark.parametrize("message", [RELEASE, WITHDRAWN], ids=["released", "withdrawn"])
def test_a_goal_that_is_not_confirmed_is_given_back(message: Message) -> None:
    rig = m7()
    rig.award_goal("G1", production())
    [ended] = facts(rig.on_message("STRATEGIST", message), ContractEnded)
    assert ended.task == "G1"
    rig.on_message("STRATEGIST", message)
    rig.confirm_goal("G1")
    assert facts(rig.all, ContractEnded) == [ended]
    rig.run(10.0)
    assert not rig.is_cycling
    assert rig.heartbeats(MachineHeartbeat)[-1].goals == ()


def test_a_release_that_comes_after_the_confirmation_changes_nothing() -> None:
    rig = m7(goal=24)
    assert deeds(rig.on_message("STRATEGIST", RELEASE)) == []
    assert rig.is_cycling


def test_a_withdrawn_goal_is_made_no_further_and_its_pieces_serve_the_next_one() -> None:
    rig = m7(goal=24)
    rig.cycles(3)
    [ended] = facts(rig.on_message("STRATEGIST", WITHDRAWN), ContractEnded)
    assert (ended.task, ended.reason) == ("G1", Reason.NOT_NEEDED)
    rig.cycle()  # The piece that was begun.
    assert not rig.is_cycling
    assert counted(rig) == []
    rig.take_goal("G2", production(quantity=5))
    rig.cycle()
    assert outgoing(rig.all) == [("G2", 5)]


def test_a_machine_tells_how_many_pieces_no_goal_wants_until_the_next_one_takes_them() -> None:
    def spare() -> int:
        rig.run(rig.now_s + 10.0)
        [goods] = rig.heartbeats(MachineHeartbeat)[-1].goods
        return goods.spare

    rig = m7(goal=24)
    rig.cycles(3)
    assert spare() == 0
    rig.on_message("STRATEGIST", WITHDRAWN)
    rig.cycle()  # The piece that was begun.
    assert spare() == 4
    rig.take_goal("G2", production(quantity=5))
    assert spare() == 0
    rig.cycle()
    assert outgoing(rig.all) == [("G2", 5)]


def test_goods_of_a_withdrawn_goal_that_nobody_has_come_for_stay_for_the_next_one() -> None:
    rig = m7(goal=2)
    rig.cycles(2)
    assert outgoing(rig.all) == [("G1", 2)]
    effects = rig.on_message("STRATEGIST", WITHDRAWN)
    assert [closed.outcome for closed in facts(effects, TaskClosed)] == ["withdrawn"]
    rig.take_goal("G2", production(quantity=2))
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 2), ("G2", 2)]


def test_goods_of_a_withdrawn_goal_that_are_not_fetched_yet_stay_for_the_next_one() -> None:
    rig = m7(goal=2)
    rig.cycles(2)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(task, "ATV2")
    effects = rig.on_message("STRATEGIST", WITHDRAWN)
    assert sent(effects, Withdrawn, to="ATV2")
    rig.take_goal("G2", production(quantity=2))
    assert not rig.is_cycling
    assert outgoing(rig.all)[-1] == ("G2", 2)


def test_goods_of_a_withdrawn_goal_that_are_on_their_way_are_left_to_the_gate() -> None:
    rig = m7(goal=2)
    rig.cycles(2)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(task, "ATV2")
    rig.stocked("pump-p3", -2, "ATV2")
    assert facts(rig.on_message("STRATEGIST", WITHDRAWN), TaskClosed) == []
    rig.take_goal("G2", production(quantity=2))
    assert rig.is_cycling


def test_spare_pieces_that_fill_the_machine_are_set_aside() -> None:
    full = FULL | {"pump-p3": 60}
    rig = MachineRig("M7", full)
    rig.start()
    works = [each.work for each in published(rig.all, TaskAnnounced)]
    assert [(work.item, work.goal) for work in works if isinstance(work, Transport)][:1] == [("pump-p3", "")]
    tasks = [each.task for each in published(rig.all, TaskAnnounced)]
    rig.hire(tasks[0], "ATV2")
    docked = rig.on_message("ATV2", Docked(task=tasks[0], epoch=1, station="M7"))
    assert instructed(docked, OpenDock) == [OpenDock(vehicle="ATV2", item="pump-p3", quantity=24)]
    rig.stocked("pump-p3", -24, "ATV2")
    rig.on_message("ATV2", handover(tasks[0]))
    rig.take_goal("G1", production(quantity=40))
    assert outgoing(rig.all)[-1] == ("G1", 24)  # Of those that are still there.
    assert rig.is_cycling


def test_a_release_of_an_earlier_award_does_not_end_the_goal_of_a_later_one() -> None:
    rig = m7()
    rig.award_goal("G1", production(quantity=24))
    again = Award(task="G1", epoch=1, role=Role.PRIMARY, work=production(), deadline_s=3600.0, number=2)
    rig.on_message("STRATEGIST", again)
    rig.on_message(
        "STRATEGIST", Release(task="G1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1)
    )
    rig.confirm_goal("G1")
    assert rig.is_cycling


def test_what_its_strategist_alone_may_say_of_a_goal_is_taken_from_nobody_else() -> None:
    rig = m7(goal=24)
    words = (
        Withdrawn(task="G1", epoch=1, reason=Reason.NOT_NEEDED),
        GoalClosed(goal="G1"),
        Release(task="G1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1),
        Confirmed(task="G1", epoch=1, arrived=24),
        Award(task="G1", epoch=2, role=Role.PRIMARY, work=production(), deadline_s=3600.0),
    )
    for word in words:
        assert rig.on_message("M8", word) == [Ignore(NO_PARTY)]
