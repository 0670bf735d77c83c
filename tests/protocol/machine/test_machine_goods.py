"""A production machine makes pieces, and has them carried away, each once."""

from __future__ import annotations

from effects import facts, instructed, published, sent
from m7 import (
    FULL,
    NO_HOUSINGS,
    counted,
    delivered,
    docked,
    handover,
    m7,
    outgoing,
    status,
    supplied_by,
    transports,
)
from rigs import MachineRig
from spoken import production

from dray.body import Broken, CycleDone, CycleFailed, Repaired, StartCycle, StockChanged
from dray.messages import (
    Accepted,
    Confirmed,
    DockOpened,
    GoalClosed,
    MachineHeartbeat,
    MachineStatus,
    Reason,
    Release,
    Resigned,
    Role,
    TaskAnnounced,
    Transport,
    Withdrawn,
)
from dray.messages.fact import ContractEnded, PieceMade, TaskClosed
from dray.protocol.runtime.events import Effect
from dray.protocol.transports.transport_flow import HELD_MAX_S

# --- making -----------------------------------------------------------------------------------------


def test_a_cycle_begins_as_soon_as_there_is_a_goal_and_material() -> None:
    started = instructed(m7(goal=24).all, StartCycle)
    assert [cycle.product for cycle in started] == ["pump-p3"]
    assert [line.material for line in started[0].bill] == ["housing", "impeller", "seal-kit"]


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
    rig.on_message("ATV2", handover(first))
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
    rig.on_message("ATV2", Resigned(task=task, epoch=1, role=Role.PRIMARY, reason=Reason.GATE_REFUSED))
    return rig


def test_a_lot_that_was_lost_is_made_anew_and_the_gate_asked() -> None:
    rig = lost_lot()
    [asked] = sent(rig.all, Accepted, to="STRATEGIST")[1:]
    assert (asked.task, asked.epoch) == ("G1", 1)
    rig.on_message("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=0))
    rig.run(rig.now_s + 60.0)
    assert len(sent(rig.all, Accepted, to="STRATEGIST")) == 2
    rig.cycles(6 + 24)
    assert sum(quantity for _, quantity in outgoing(rig.all)) == 24 + 30
    assert not rig.is_cycling


def test_a_lot_that_was_lost_and_arrived_all_the_same_is_not_made_anew() -> None:
    rig = lost_lot()
    rig.on_message("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=24))
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
    [ended] = facts(rig.on_message("STRATEGIST", GoalClosed(goal="G1")), ContractEnded)
    assert ended.reason == Reason.DELIVERED
    rig.on_message("STRATEGIST", GoalClosed(goal="G1"))
    rig.run(rig.now_s + 20.0)
    assert rig.heartbeats(MachineHeartbeat)[-1].goals == ()
    assert len(facts(rig.all, ContractEnded)) == 1


def test_an_award_of_a_goal_that_is_delivered_already_begins_nothing() -> None:
    rig = m7(goal=1)
    rig.cycle()
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    delivered(rig, task)
    rig.on_message("STRATEGIST", GoalClosed(goal="G1"))
    rig.award_goal("G1", production(quantity=1))
    rig.on_message(
        "STRATEGIST", Release(task="G1", epoch=1, role=Role.PRIMARY, reason=Reason.TASK_ENDED, number=1)
    )
    rig.run(rig.now_s + 60.0)
    assert len(instructed(rig.all, StartCycle)) == 1
    assert rig.heartbeats(MachineHeartbeat)[-1].goals == ()


def lots_out(rig: MachineRig) -> list[tuple[str, int]]:
    """Every transport of pumps that was announced: its name and how many."""
    return [
        (message.task, message.work.quantity)
        for message in published(rig.all, TaskAnnounced)
        if message.round == 1
        and message.role is Role.PRIMARY
        and isinstance(message.work, Transport)
        and message.work.item == "pump-p3"
    ]


def test_a_report_that_is_heard_after_the_state_that_it_explains_is_not_counted_twice() -> None:
    rig = m7(FULL, goal=48)
    rig.cycles(48)
    (first, _), (second, _) = lots_out(rig)
    rig.hire(first, "ATV2")
    rig.hire(second, "ATV3")
    # The worker senses the workcell when it wakes its agent; what has happened just then is reported behind that.
    rig.stock["pump-p3"] -= 24
    rig.seq += 1
    rig.wake()
    rig.report(StockChanged(item="pump-p3", change=-24, seq=rig.seq, vehicle="ATV2"))
    effects = rig.on_message("ATV3", docked(second))
    assert len(sent(effects, DockOpened, to="ATV3")) == 1
    assert facts(effects, TaskClosed) == []
    rig.run(rig.now_s + 5.0)
    assert rig.reported_stock()[1][0].level == 24


def test_a_piece_that_is_sensed_before_it_is_reported_is_counted_once() -> None:
    rig = m7(FULL, goal=2)
    rig.stock["pump-p3"] = 1
    rig.seq += 1
    rig.wake()
    rig.report(CycleDone(product="pump-p3", seq=rig.seq))
    rig.run(rig.now_s + 5.0)
    beat = rig.heartbeats(MachineHeartbeat)[-1]
    assert (rig.reported_stock()[1][0].level, beat.goals[0].made) == (1, 1)


def test_what_was_reported_before_the_start_is_in_the_first_count() -> None:
    rig = MachineRig("M7", FULL | {"pump-p3": 1}, incarnation=2)
    rig.seq = 1
    rig.start()
    rig.report(CycleDone(product="pump-p3", seq=1))
    rig.report(StockChanged(item="pump-p3", change=1, seq=1))
    rig.take_goal("G1", production(quantity=2))
    rig.run(rig.now_s + 5.0)
    beat = rig.heartbeats(MachineHeartbeat)[-1]
    assert (rig.reported_stock()[1][0].level, beat.goals[0].made) == (1, 1)


def test_a_state_from_before_the_cycle_gives_no_material_back() -> None:
    class Elsewhere(MachineRig):
        """A workcell that has not heard of the cycle yet."""

        @property
        def cycling(self) -> str:
            return ""

    rig = Elsewhere("M7", FULL)
    rig.start()
    rig.take_goal("G1", production(quantity=2))
    rig.stock |= FULL
    rig.run(rig.now_s + 5.0)
    levels = {each.item: each.level for each in rig.reported_stock()[0]}
    assert levels == {item: level - 1 for item, level in FULL.items()}


def test_spare_pieces_that_a_person_has_taken_off_their_carrier_are_written_off() -> None:
    rig = MachineRig("M7", NO_HOUSINGS | {"pump-p3": 60})
    rig.start()
    rig.run(1.0)
    [(task, quantity)] = lots_out(rig)
    rig.hire(task, "ATV2")
    rig.stocked("pump-p3", -quantity, "ATV2")
    rig.take_goal("G1", production(quantity=36))
    for (other, pieces), atv in zip(lots_out(rig)[1:], ("ATV3", "ATV4"), strict=True):
        rig.hire(other, atv)
        rig.stocked("pump-p3", -pieces, atv)
    # Its load is gone for good; the carrier has come back for another one, and there is none.
    effects: list[Effect] = []
    while not sent(effects, Withdrawn, to="ATV2"):
        assert rig.now_s < 3 * HELD_MAX_S
        effects = rig.on_message("ATV2", docked(task))
        rig.now_s += 5.0
    assert [fact.task for fact in facts(effects, TaskClosed)] == [task]
