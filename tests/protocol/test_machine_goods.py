"""A production machine makes pieces, and has them carried away, each once."""

from __future__ import annotations

from kit import MachineRig, facts, instructed, production, published, sent
from m7 import FULL, NO_HOUSINGS, counted, delivered, handover, m7, outgoing, status, supplied_by, transports

from dray.body import Broken, CycleFailed, Repaired, StartCycle
from dray.messages import (
    Accepted,
    Confirmed,
    GoalClosed,
    MachineHeartbeat,
    MachineStatus,
    Release,
    Resigned,
    Role,
    TaskAnnounced,
    Transport,
)
from dray.messages.fact import ContractEnded, PieceMade

# --- making -----------------------------------------------------------------------------------------


def test_a_cycle_begins_as_soon_as_there_is_a_goal_and_material() -> None:
    assert instructed(m7(goal=24).all, StartCycle) == [StartCycle(product="pump-p3")]


def test_one_cycle_runs_at_a_time_and_as_many_as_the_goal_has_pieces() -> None:
    rig = m7(goal=5)
    rig.take_goal("G2", production(quantity=2, order="O2"))
    assert len(instructed(rig.all, StartCycle)) == 1
    rig.cycles(7)
    assert not rig.is_cycling
    made = facts(rig.all, PieceMade)
    assert [(fact.goal, fact.made) for fact in made] == [
        *(("G1", piece) for piece in range(1, 6)),
        ("G2", 1),
        ("G2", 2),
    ]


def test_the_most_urgent_goal_is_made_first() -> None:
    rig = m7(NO_HOUSINGS)
    rig.take_goal("LATER", production(quantity=1), deadline_s=2000.0)
    rig.take_goal("SOONER", production(quantity=1, order="O2"), deadline_s=1000.0)
    rig.stocked("housing", 2)
    rig.cycles(2)
    assert [fact.goal for fact in facts(rig.all, PieceMade)] == ["SOONER", "LATER"]


def test_a_cycle_begins_when_the_missing_material_comes() -> None:
    rig = supplied_by("ATV2")
    assert not rig.is_cycling
    effects = rig.stocked("housing", 24, "ATV2")
    assert instructed(effects, StartCycle)


def test_a_cycle_that_could_not_start_is_tried_again() -> None:
    rig = m7(goal=24)
    rig.stock |= FULL
    rig.report(CycleFailed(product="pump-p3", reason="the door is open"))
    assert instructed(rig.run(10.0), StartCycle)


def test_a_broken_machine_begins_nothing_until_it_is_repaired() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.report(Broken(reason="oil"))
    assert instructed(rig.stocked("housing", 24), StartCycle) == []
    assert instructed(rig.report(Repaired()), StartCycle)


def test_a_cycle_that_paused_with_its_machine_ends_later() -> None:
    rig = m7(goal=2)
    rig.report(Broken(reason="oil"))
    assert instructed(rig.report(Repaired()), StartCycle) == []
    rig.cycles(2)
    assert facts(rig.all, PieceMade)[-1].made == 2


# --- goods ------------------------------------------------------------------------------------------


def test_goods_are_carried_away_in_lots_and_the_remainder_at_the_goals_end() -> None:
    rig = m7(goal=58)
    sizes: list[tuple[int, int]] = []
    for piece in range(1, 59):
        effects = rig.cycle()
        sizes += [(piece, quantity) for _, quantity in outgoing(effects)]
    assert sizes == [(24, 24), (48, 24), (58, 10)]
    [lot, *_] = [work for work in transports(rig.all) if work.goal]
    assert lot == Transport(
        item="pump-p3",
        quantity=24,
        sources=("M7",),
        destination="DELIVERY",
        ability="tote",
        goal="G1",
    )


def test_goods_of_two_goals_travel_apart() -> None:
    rig = m7(goal=10)
    rig.take_goal("G2", production(quantity=14, order="O2"))
    rig.cycles(24)
    assert outgoing(rig.all) == [("G1", 10), ("G2", 14)]


def test_delivered_goods_count_for_their_goal_once() -> None:
    rig = m7(goal=30)
    rig.cycles(30)
    first, second = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    delivered(rig, first)
    assert counted(rig) == [("G1", 30, 24)]
    rig.hear("ATV2", handover(first))
    assert counted(rig) == [("G1", 30, 24)]
    delivered(rig, second)
    assert counted(rig) == [("G1", 30, 30)]


def test_a_full_goods_buffer_blocks_the_machine_until_it_is_emptied() -> None:
    rig = m7(goal=70)
    rig.cycles(24)
    tasks = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    for _ in range(40):
        if not rig.is_cycling:
            break
        rig.stock |= FULL
        rig.run(rig.now_s + 10.0)
        rig.cycle()
    assert rig.stock["pump-p3"] == 60
    rig.run(rig.now_s + 5.0)
    assert status(rig) is MachineStatus.BLOCKED
    delivered(rig, tasks[0])
    assert rig.is_cycling
    rig.run(rig.now_s + 1.0)
    assert status(rig) is MachineStatus.PRODUCING


def test_goods_of_interrupted_goals_are_sent_when_they_fill_the_machine() -> None:
    rig = m7()
    for name, deadline_s, pieces in (("A", 3000.0, 22), ("B", 2000.0, 23), ("C", 1000.0, 15)):
        rig.take_goal(name, production(quantity=48, order=f"O{name}"), deadline_s)
        for _ in range(pieces):
            assert outgoing(rig.all) == []
            for material, full in FULL.items():
                rig.stocked(material, full - rig.stock[material])
            rig.cycle()
    assert rig.stock["pump-p3"] == 60
    # The cycle that ran when B came in was A's, and so on: each goal has one more of the interrupted one's.
    assert sorted(goal for goal, _ in outgoing(rig.all)) == ["A", "B", "C"]
    assert sum(quantity for _, quantity in outgoing(rig.all)) == 60
    delivered(rig, "M7-1")
    assert rig.is_cycling


# --- pieces that get lost ---------------------------------------------------------------------------


def lost_lot() -> MachineRig:
    """A vehicle has resigned from a lot of 24 of G1 that it had on board."""
    rig = m7(goal=30)
    rig.cycles(24)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(task, "ATV2")
    rig.stocked("pump-p3", -24, "ATV2")
    rig.stock |= FULL
    rig.hear("ATV2", Resigned(task=task, epoch=1, role=Role.PRIMARY, reason="refused: not admitted"))
    return rig


def test_a_lot_that_was_lost_is_made_anew_and_the_gate_asked() -> None:
    rig = lost_lot()
    [asked] = sent(rig.all, Accepted, to="STRATEGIST")[1:]
    assert (asked.task, asked.epoch) == ("G1", 1)
    rig.hear("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=0))
    rig.run(rig.now_s + 60.0)
    assert len(sent(rig.all, Accepted, to="STRATEGIST")) == 2
    rig.cycles(6 + 24)
    assert sum(quantity for _, quantity in outgoing(rig.all)) == 24 + 30
    assert not rig.is_cycling


def test_a_lot_that_was_lost_and_arrived_all_the_same_is_not_made_anew() -> None:
    rig = lost_lot()
    rig.hear("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=24))
    assert counted(rig) == [("G1", 24, 24)]
    rig.cycles(6)
    assert not rig.is_cycling
    assert [quantity for _, quantity in outgoing(rig.all)] == [24, 6]


def test_a_goal_stays_in_the_heartbeat_until_the_strategist_has_closed_it() -> None:
    rig = m7(goal=24)
    rig.cycles(24)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    delivered(rig, task)
    rig.run(rig.now_s + 20.0)
    [brief] = rig.heartbeats(MachineHeartbeat)[-1].goals
    assert (brief.made, brief.delivered, brief.quantity) == (24, 24, 24)
    [ended] = facts(rig.hear("STRATEGIST", GoalClosed(goal="G1")), ContractEnded)
    assert ended.reason == "delivered"
    rig.hear("STRATEGIST", GoalClosed(goal="G1"))
    rig.run(rig.now_s + 20.0)
    assert rig.heartbeats(MachineHeartbeat)[-1].goals == ()
    assert len(facts(rig.all, ContractEnded)) == 1


def test_an_award_of_a_goal_that_is_delivered_already_begins_nothing() -> None:
    rig = m7(goal=1)
    rig.cycle()
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    delivered(rig, task)
    rig.hear("STRATEGIST", GoalClosed(goal="G1"))
    rig.award_goal("G1", production(quantity=1))
    rig.hear("STRATEGIST", Release(task="G1", epoch=1, role=Role.PRIMARY, reason="the task has ended"))
    rig.run(rig.now_s + 60.0)
    assert len(instructed(rig.all, StartCycle)) == 1
    assert rig.heartbeats(MachineHeartbeat)[-1].goals == ()
