"""A production machine: makes goals, orders material, has its products carried away (paper, 3.2)."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import pytest
from kit import (
    KEYS,
    PLANT,
    MachineRig,
    accepted,
    announcement,
    bid,
    committed,
    deeds,
    facts,
    goal_bid,
    instructed,
    listening,
    mhb,
    production,
    published,
    rhb,
    sent,
    transport,
)

from dray.body import (
    Broken,
    CycleDone,
    CycleFailed,
    OpenDock,
    Repaired,
    StartCycle,
    VehicleState,
    WorkcellState,
)
from dray.errors import ProtocolViolation
from dray.memory import MachineMemory
from dray.messages import (
    Accepted,
    Award,
    BerthClaimed,
    Bid,
    CommandKind,
    Confirmed,
    Declined,
    Docked,
    DockHeld,
    DockOpened,
    GoalClosed,
    Handover,
    HandoverAccepted,
    MachineHeartbeat,
    MachineStatus,
    Message,
    Refusal,
    Release,
    Resigned,
    Role,
    Superseded,
    TaskAnnounced,
    Transport,
    VehicleCommand,
    Withdrawn,
)
from dray.messages.fact import (
    BidRefused,
    ContractEnded,
    ContractTaken,
    MachineStatusChanged,
    PieceMade,
    TaskClosed,
)
from dray.protocol.events import Commit, Effect, Reported, Woke
from dray.protocol.insisting import ASK_AGAIN_S

# M7 makes pumps alone: one housing, impeller and seal kit each, 50 s; lots of 24, room for 60.
FULL = {"housing": 72, "impeller": 90, "seal-kit": 120}
NO_HOUSINGS = FULL | {"housing": 0}


def m7(stock: dict[str, int] = FULL, *, goal: int = 0) -> MachineRig:
    """M7, started, with a goal of that many pumps unless none."""
    rig = MachineRig("M7", stock)
    rig.start()
    if goal:
        rig.take_goal("G1", production(quantity=goal))
    return rig


def transports(effects: list[Effect]) -> list[Transport]:
    """The work of all transports that were announced for the first time."""
    return [
        message.work
        for message in published(effects, TaskAnnounced)
        if message.round == 1 and message.role is Role.PRIMARY and isinstance(message.work, Transport)
    ]


def incoming(effects: list[Effect]) -> list[tuple[str, int]]:
    return [(work.item, work.quantity) for work in transports(effects) if not work.goal]


def outgoing(effects: list[Effect]) -> list[tuple[str, int]]:
    return [(work.goal, work.quantity) for work in transports(effects) if work.goal]


def status(rig: MachineRig) -> MachineStatus:
    return rig.heartbeats(MachineHeartbeat)[-1].status


def docked(task: str = "M7-1", epoch: int = 1, station: str = "M7") -> Docked:
    return Docked(task=task, epoch=epoch, station=station)


def handover(task: str = "M7-1", epoch: int = 1, quantity: int = 24) -> Handover:
    return Handover(task=task, epoch=epoch, quantity=quantity)


def supplied_by(atv: str = "ATV2", stock: dict[str, int] = NO_HOUSINGS) -> MachineRig:
    """M7 without housings; a vehicle is contracted to bring some (M7-1)."""
    rig = m7(stock, goal=24)
    rig.hire("M7-1", atv)
    return rig


# --- ordering material ---------------------------------------------------------------------------


def test_without_a_goal_nothing_is_ordered_however_empty_the_buffers_are() -> None:
    rig = m7({})
    assert transports(rig.run(60.0)) == []


def test_a_machine_orders_a_lot_of_everything_it_lacks_when_it_takes_a_goal() -> None:
    rig = m7({}, goal=24)
    assert incoming(rig.all) == [("housing", 24), ("impeller", 30), ("seal-kit", 40)]


def test_an_order_names_storages_destination_ability_and_a_deadline_that_can_be_kept() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    [announced] = published(rig.all, TaskAnnounced)
    assert announced.work == Transport(
        item="housing",
        quantity=24,
        sources=PLANT.storages_of("housing"),
        destination="M7",
        ability="pallet",
    )
    assert announced.deadline_s > 30.0
    assert announced.coordinator == "M7"
    assert (announced.x_m, announced.y_m) == PLANT.position_of("M7")


def test_material_is_ordered_at_the_reorder_point_and_not_before() -> None:
    rig = m7(FULL | {"housing": 24}, goal=1000)
    rig.run(1.0)
    point = rig.heartbeats(MachineHeartbeat)[-1].buffers[0].reorder_point
    assert 1 < point < 20
    while rig.stock["housing"] > point + 1:
        assert incoming(rig.cycle()) == []
    assert ("housing", 24) in incoming(rig.cycle())
    assert rig.stock["housing"] == point


def test_one_need_is_never_ordered_twice() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.run(120.0)
    rig.stocked("seal-kit", -1)
    rig.stocked("seal-kit", 1)
    rig.report(Broken(reason="oil"))
    rig.report(Repaired())
    assert incoming(rig.all) == [("housing", 24)]


def test_no_more_is_ordered_than_all_goals_need() -> None:
    rig = m7(NO_HOUSINGS, goal=20)
    rig.hire("M7-1", "ATV2")
    rig.stocked("housing", 24, "ATV2")
    rig.hear("ATV2", handover())
    rig.cycles(20)
    rig.run(rig.now_s + 60.0)
    assert incoming(rig.all) == [("housing", 24)]


def test_a_need_that_grows_is_ordered_for() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.hire("M7-1", "ATV2")
    rig.take_goal("G2", production(quantity=24, order="O2"))
    rig.stocked("housing", 24, "ATV2")
    effects = rig.hear("ATV2", handover())
    effects += rig.cycles(24)
    assert ("housing", 24) in incoming(effects)


def test_material_for_several_products_is_ordered_once_for_all() -> None:
    rig = MachineRig("M8", {"impeller": 90, "seal-kit": 120, "shaft": 120, "bearing": 120})
    rig.start()
    rig.take_goal("PUMP", production(quantity=10))
    rig.take_goal("GEAR", production(product="gear-unit-g2", quantity=10, order="O2"))
    assert incoming(rig.all) == [("housing", 24)]


def test_every_task_has_a_name_of_its_own_in_every_life() -> None:
    names = []
    for incarnation in (1, 2):
        rig = MachineRig("M7", {}, incarnation=incarnation)
        rig.start()
        rig.take_goal("G1", production())
        names += [message.task for message in published(rig.all, TaskAnnounced)]
    assert len(names) == len(set(names)) == 6


def test_announcements_go_to_the_cells_within_the_radius_alone() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    keys = {effect.key for effect in rig.all if published([effect], TaskAnnounced)}  # type: ignore[union-attr]
    x_m, y_m = PLANT.position_of("M7")
    assert keys == {KEYS.transports(cell) for cell in PLANT.cells_within(x_m, y_m, 25.0)}


# --- the dock ------------------------------------------------------------------------------------


def test_the_primary_is_let_in_for_its_load_alone() -> None:
    rig = supplied_by("ATV2")
    effects = rig.hear("ATV2", docked())
    assert sent(effects, DockOpened, to="ATV2") == [DockOpened(task="M7-1", epoch=1, station="M7")]
    assert instructed(effects, OpenDock) == [OpenDock(vehicle="ATV2", item="housing", quantity=24)]


def test_the_dock_is_open_before_the_vehicle_hears_of_it() -> None:
    effects = supplied_by("ATV2").hear("ATV2", docked())
    kinds = [bool(instructed([effect], OpenDock)) for effect in effects]
    assert kinds == [True, False]


@pytest.mark.parametrize(
    ("sender", "message"),
    [
        ("ATV2", docked(epoch=0)),
        ("ATV2", docked(epoch=2)),
        ("ATV7", docked()),
        ("ATV2", docked(task="M7-99")),
        ("ATV2", handover(epoch=0)),
        ("ATV2", handover(epoch=2)),
        ("ATV7", handover()),
        ("ATV2", handover(task="M7-99")),
    ],
    ids=lambda value: (
        f"{type(value).__name__} {value.task} {value.epoch}" if isinstance(value, Message) else value
    ),
)
def test_an_old_epoch_a_stranger_or_an_unknown_task_is_superseded_and_gets_no_dock(
    sender: str, message: Docked | Handover
) -> None:
    rig = supplied_by("ATV2")
    effects = rig.hear(sender, message)
    [superseded] = sent(effects, Superseded, to=sender)
    assert superseded.task == message.task
    assert superseded.epoch == (1 if message.task == "M7-1" else 0)
    assert instructed(effects, OpenDock) == []
    assert facts(effects, TaskClosed) == []


def test_nobody_is_let_in_while_a_carrier_is_still_sought() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    effects = rig.hear("ATV2", docked())
    assert sent(effects, Superseded, to="ATV2")
    assert instructed(effects, OpenDock) == []


def test_the_dock_is_held_while_the_buffer_has_no_room() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 72)
    effects = rig.hear("ATV2", docked())
    [held] = sent(effects, DockHeld, to="ATV2")
    assert held.reason == "the buffer is full"
    assert instructed(effects, OpenDock) == []
    rig.stocked("housing", -24)
    assert sent(rig.hear("ATV2", docked()), DockOpened)


def test_a_dock_that_is_asked_for_twice_is_opened_twice_for_the_same_load() -> None:
    rig = supplied_by("ATV2")
    first, second = rig.hear("ATV2", docked()), rig.hear("ATV2", docked())
    assert first == second


def test_a_carrier_may_put_goods_down_at_the_warehouse_without_the_machines_dock() -> None:
    rig = m7(goal=24)
    rig.cycles(24)
    [announced] = [each for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(announced.task, "ATV2")
    effects = rig.hear("ATV2", docked(announced.task, station="DELIVERY"))
    assert sent(effects, DockOpened, to="ATV2")
    assert instructed(effects, OpenDock) == []


def test_a_lot_that_is_not_whole_any_more_is_made_whole_before_it_is_given_out() -> None:
    rig = m7(goal=24)
    rig.cycles(24)
    [announced] = [each for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(announced.task, "ATV2")
    rig.stocked("pump-p3", -1)
    effects = rig.hear("ATV2", docked(announced.task))
    assert sent(effects, DockOpened) == []
    assert sent(rig.all, Withdrawn, to="ATV2")
    rig.stock |= FULL
    rig.run(rig.now_s + 5.0)
    rig.cycle()
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 24), ("G1", 24)]


def test_material_that_finds_no_room_is_not_waited_with_for_ever() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 72)
    rig.run(rig.now_s + 5.0)
    for _ in range(12):
        effects = rig.hear("ATV2", docked())
        assert sent(effects, Withdrawn) == []
        [held] = sent(effects, DockHeld)
        assert held.reason == "the buffer is full"
        rig.now_s += 5.0
    rig.now_s += 1.0
    assert sent(rig.hear("ATV2", docked()), Withdrawn, to="ATV2")


# --- the handover --------------------------------------------------------------------------------


def test_a_handover_ends_the_task_and_is_accepted() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 24, "ATV2")
    effects = rig.hear("ATV2", handover())
    assert sent(effects, HandoverAccepted, to="ATV2") == [HandoverAccepted(task="M7-1", epoch=1)]
    [closed] = facts(effects, TaskClosed)
    assert (closed.task, closed.outcome, closed.carrier) == ("M7-1", "delivered", "ATV2")


def test_handing_over_twice_is_harmless() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 24, "ATV2")
    rig.hear("ATV2", handover())
    effects = rig.hear("ATV2", handover())
    assert effects == [effect for effect in effects if sent([effect], HandoverAccepted, to="ATV2")]
    assert len(effects) == 1


def test_a_handover_of_somebody_elses_delivered_task_is_superseded() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 24, "ATV2")
    rig.hear("ATV2", handover())
    assert sent(rig.hear("ATV7", handover()), Superseded, to="ATV7")


def test_what_is_handed_over_is_on_order_no_longer() -> None:
    rig = supplied_by("ATV2")
    rig.run(rig.now_s + 1.0)
    assert rig.heartbeats(MachineHeartbeat)[-1].buffers[0].on_order == 24
    rig.stocked("housing", 24, "ATV2")
    rig.hear("ATV2", handover())
    rig.run(rig.now_s)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert last.buffers[0].on_order == 0
    assert last.tasks == ()


# --- making --------------------------------------------------------------------------------------


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


# --- goods ---------------------------------------------------------------------------------------


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


def delivered(rig: MachineRig, task: str) -> list[Effect]:
    """A vehicle carries a lot of goods away."""
    rig.hire(task, "ATV2")
    [work] = [each.work for each in published(rig.all, TaskAnnounced) if each.task == task][:1]
    rig.stocked("pump-p3", -work.quantity, "ATV2")  # type: ignore[union-attr]
    return rig.hear("ATV2", handover(task, quantity=work.quantity))  # type: ignore[union-attr]


def counted(rig: MachineRig) -> list[tuple[str, int, int]]:
    """What the next heartbeat says of goals: name, made, delivered."""
    rig.run(rig.now_s + 5.0)
    return [(brief.goal, brief.made, brief.delivered) for brief in rig.heartbeats(MachineHeartbeat)[-1].goals]


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


# --- goals ---------------------------------------------------------------------------------------


def test_a_machine_listens_for_the_goals_it_can_make() -> None:
    rig = MachineRig("M8")
    assert listening(rig.start()) == {KEYS.goals("gear-unit-g2"), KEYS.goals("pump-p3")}


def test_a_machine_bids_for_a_goal_with_the_parts_of_its_price() -> None:
    rig = m7()
    effects = rig.hear("S", announcement(task="G1", coordinator="STRATEGIST", work=production()))
    [bid_] = sent(effects, Bid, to="STRATEGIST")
    assert bid_.cost.total_s == 24 * 50.0
    assert bid_.finish_s == rig.now_s + 24 * 50.0


def test_a_machine_with_a_queue_is_dearer() -> None:
    ask = announcement(task="G9", coordinator="STRATEGIST", work=production())
    idle_s, busy_s = (sent(rig.hear("S", ask), Bid)[0].cost.total_s for rig in (m7(), m7(goal=24)))
    assert busy_s == idle_s + 24 * 50.0


def test_transports_and_other_products_are_not_bid_for() -> None:
    rig = m7()
    assert rig.hear("M8", announcement()) == []
    other = production(product="gear-unit-g1")
    assert rig.hear("S", announcement(coordinator="STRATEGIST", work=other)) == []


@pytest.mark.parametrize("product", ["gear-unit-g1", "nonsense"])
def test_an_award_of_what_the_machine_does_not_make_is_declined(product: str) -> None:
    rig = m7()
    [declined] = sent(rig.award_goal("G1", production(product=product)), Declined, to="STRATEGIST")
    assert (declined.task, declined.reason) == ("G1", Refusal.ABILITY)
    assert facts(rig.all, ContractTaken) == []


def test_a_transport_is_not_for_machines() -> None:
    rig = m7()
    carrying = Award(task="T", epoch=1, role=Role.PRIMARY, work=transport(), deadline_s=1.0, number=3)
    [declined] = sent(rig.hear("M8", carrying), Declined, to="M8")
    assert (declined.reason, declined.number) == (Refusal.ABILITY, 3)


def test_a_broken_machine_refuses_with_its_reason() -> None:
    rig = m7()
    rig.report(Broken(reason="oil"))
    ask = announcement(task="G1", coordinator="STRATEGIST", work=production())
    [refused] = facts(rig.hear("S", ask), BidRefused)
    assert (refused.reason, refused.detail) == (Refusal.NOT_FIT, "oil")
    [declined] = sent(rig.take_goal("G1", production()), Declined)
    assert declined.reason is Refusal.NOT_FIT


def test_a_goal_that_is_awarded_is_accepted_with_what_was_promised() -> None:
    rig = m7()
    rig.hear("S", announcement(task="G1", coordinator="STRATEGIST", work=production()))
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
    assert repeated == [first] * 4
    rig.confirm_goal("G1")
    assert sent(rig.run(rig.now_s + 60.0), Accepted) == []


def test_an_acceptance_is_repeated_no_more_after_a_release() -> None:
    rig = m7()
    rig.award_goal("G1", production())
    rig.hear("STRATEGIST", Release(task="G1", epoch=1, role=Role.PRIMARY, reason="no answer"))
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
    [first] = sent(rig.hear("STRATEGIST", given), Accepted)
    [second] = sent(rig.hear("STRATEGIST", msgspec.structs.replace(given, number=5)), Accepted)
    assert (first.number, second.number) == (2, 5)
    assert {answer.number for answer in sent(rig.run(10.0), Accepted)} == {5}


def test_a_goal_whose_promise_has_become_empty_is_declined() -> None:
    rig = m7()
    rig.hear("S", announcement(task="G1", coordinator="STRATEGIST", work=production()))
    rig.take_goal("G2", production(order="O2"))
    [declined] = sent(rig.take_goal("G1", production()), Declined, to="STRATEGIST")
    assert declined.reason is Refusal.BUSY
    assert declined.task == "G1"


RELEASE = Release(task="G1", epoch=1, role=Role.PRIMARY, reason="no answer")
WITHDRAWN = Withdrawn(task="G1", epoch=1, reason="not needed any more")


@pytest.mark.parametrize("message", [RELEASE, WITHDRAWN], ids=["released", "withdrawn"])
def test_a_goal_that_is_not_confirmed_is_given_back(message: Message) -> None:
    rig = m7()
    rig.award_goal("G1", production())
    [ended] = facts(rig.hear("STRATEGIST", message), ContractEnded)
    assert ended.task == "G1"
    rig.hear("STRATEGIST", message)
    rig.confirm_goal("G1")
    assert facts(rig.all, ContractEnded) == [ended]
    rig.run(10.0)
    assert not rig.is_cycling
    assert rig.heartbeats(MachineHeartbeat)[-1].goals == ()


def test_a_release_that_comes_after_the_confirmation_changes_nothing() -> None:
    rig = m7(goal=24)
    assert deeds(rig.hear("STRATEGIST", RELEASE)) == []
    assert rig.is_cycling


def test_a_withdrawn_goal_is_made_no_further_and_its_pieces_serve_the_next_one() -> None:
    rig = m7(goal=24)
    rig.cycles(3)
    [ended] = facts(rig.hear("STRATEGIST", WITHDRAWN), ContractEnded)
    assert (ended.task, ended.reason) == ("G1", "not needed any more")
    rig.cycle()  # The piece that was begun.
    assert not rig.is_cycling
    assert counted(rig) == []
    rig.take_goal("G2", production(quantity=5))
    rig.cycle()
    assert outgoing(rig.all) == [("G2", 5)]


def test_goods_of_a_withdrawn_goal_that_nobody_has_come_for_stay_for_the_next_one() -> None:
    rig = m7(goal=2)
    rig.cycles(2)
    assert outgoing(rig.all) == [("G1", 2)]
    effects = rig.hear("STRATEGIST", WITHDRAWN)
    assert [closed.outcome for closed in facts(effects, TaskClosed)] == ["withdrawn"]
    rig.take_goal("G2", production(quantity=2))
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 2), ("G2", 2)]


def test_goods_of_a_withdrawn_goal_that_are_not_fetched_yet_stay_for_the_next_one() -> None:
    rig = m7(goal=2)
    rig.cycles(2)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(task, "ATV2")
    effects = rig.hear("STRATEGIST", WITHDRAWN)
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
    assert facts(rig.hear("STRATEGIST", WITHDRAWN), TaskClosed) == []
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
    docked = rig.hear("ATV2", Docked(task=tasks[0], epoch=1, station="M7"))
    assert instructed(docked, OpenDock) == [OpenDock(vehicle="ATV2", item="pump-p3", quantity=24)]
    rig.stocked("pump-p3", -24, "ATV2")
    rig.hear("ATV2", handover(tasks[0]))
    rig.take_goal("G1", production(quantity=40))
    assert outgoing(rig.all)[-1] == ("G1", 24)  # Of those that are still there.
    assert rig.is_cycling


# --- pieces that get lost ------------------------------------------------------------------------


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


# --- what an earlier life has left ---------------------------------------------------------------


def reborn(rig: MachineRig, **stock: int) -> MachineRig:
    """The machine is started again, with its workcell as it is and what it had written down."""
    again = MachineRig(
        "M7", rig.stock | {key.replace("_", "-"): each for key, each in stock.items()}, incarnation=2
    )
    again.memory, again.now_s = committed(rig.all), rig.now_s
    again.start()
    return again


def test_a_machine_goes_on_with_its_goals_and_asks_for_them_until_it_is_answered() -> None:
    rig = m7(goal=24)
    rig.cycles(5)
    again = reborn(rig)
    assert again.is_cycling
    assert counted(again) == [("G1", 5, 0)]
    asked = sent(again.all, Accepted, to="STRATEGIST")
    assert len(asked) > 1
    assert {(each.task, each.epoch) for each in asked} == {("G1", 1)}
    again.confirm_goal("G1")
    assert sent(again.run(again.now_s + 60.0), Accepted) == []
    again.cycles(19)
    assert outgoing(again.all) == [("G1", 24)]
    assert not again.is_cycling


def test_a_goal_that_others_have_got_meanwhile_ends_with_the_answer() -> None:
    rig = m7(goal=24)
    rig.cycles(5)
    again = reborn(rig)
    again.hear("STRATEGIST", RELEASE)
    again.cycle()
    assert counted(again) == []
    again.take_goal("G2", production(quantity=6))
    assert outgoing(again.all) == [("G2", 6)]


def test_goods_on_the_way_are_neither_made_again_nor_counted_twice() -> None:
    rig = m7(goal=30)
    rig.cycles(25)
    first, *_ = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(first, "ATV2")
    rig.stocked("pump-p3", -24, "ATV2")
    again = reborn(rig)
    again.hear("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=24))  # It is in, and not handed over yet.
    assert counted(again) == [("G1", 25, 0)]
    again.hear("ATV2", handover(first))
    assert counted(again) == [("G1", 25, 24)]
    again.stock |= FULL
    again.run(again.now_s + 5.0)
    again.cycles(5)
    assert outgoing(again.all)[-1] == ("G1", 6)
    assert not again.is_cycling


def test_goods_that_wait_for_a_vehicle_are_no_spare_pieces_in_the_next_life() -> None:
    rig = m7(goal=2)
    rig.cycles(2)
    again = reborn(rig)
    again.take_goal("G2", production(quantity=1))
    assert again.is_cycling


def test_a_piece_that_was_made_between_two_lives_serves_the_goal() -> None:
    rig = m7(goal=2)
    rig.cycle()
    again = reborn(rig, pump_p3=2)
    assert not again.is_cycling
    assert outgoing(again.all) == [("G1", 2)]


def test_what_was_handed_over_is_written_down_before_the_vehicle_is_told() -> None:
    rig = m7(goal=24)
    rig.cycles(24)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    effects = delivered(rig, task)
    assert isinstance(effects[0], Commit)
    memory = committed(effects)
    assert isinstance(memory, MachineMemory)
    assert [(goal.made, goal.delivered) for goal in memory.goals] == [(24, 24)]


def test_a_cycle_that_an_earlier_life_has_begun_makes_a_piece_for_the_next_goal() -> None:
    rig = MachineRig("M7", FULL, incarnation=2)
    rig.start()
    rig.report(CycleDone(product="pump-p3"))
    assert facts(rig.all, PieceMade) == []
    effects = rig.take_goal("G1", production(quantity=3))
    assert [(fact.goal, fact.made) for fact in facts(effects, PieceMade)] == [("G1", 1)]
    rig.cycles(2)
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 3)]


def test_a_machine_that_starts_in_the_middle_of_a_cycle_waits_for_its_end() -> None:
    class Running(MachineRig):
        def sense(self) -> WorkcellState:
            return WorkcellState(stock=dict(self.stock), cycling="pump-p3", broken="")

    rig = Running("M7", FULL, incarnation=2)
    rig.start()
    rig.take_goal("G1", production(quantity=3))
    assert instructed(rig.all, StartCycle) == []
    rig.run(1.0)
    assert status(rig) is MachineStatus.PRODUCING
    assert instructed(rig.report(CycleDone(product="pump-p3")), StartCycle)


def test_finished_pieces_that_lie_there_at_the_start_are_used_for_the_first_goals() -> None:
    rig = m7(FULL | {"pump-p3": 30})
    rig.take_goal("G1", production(quantity=24))
    assert outgoing(rig.all) == [("G1", 24)]
    assert not rig.is_cycling
    rig.take_goal("G2", production(quantity=10, order="O2"))
    rig.cycles(4)
    assert not rig.is_cycling
    assert outgoing(rig.all) == [("G1", 24), ("G2", 10)]


# --- status and heartbeats -----------------------------------------------------------------------


def test_a_machine_without_a_goal_is_idle() -> None:
    rig = m7()
    rig.run(1.0)
    assert status(rig) is MachineStatus.IDLE


def test_a_machine_that_lacks_material_is_starved_and_one_that_has_it_produces() -> None:
    rig = m7(NO_HOUSINGS, goal=2)
    rig.run(1.0)
    assert status(rig) is MachineStatus.STARVED
    rig.stocked("housing", 24)
    rig.run(1.0)
    assert status(rig) is MachineStatus.PRODUCING
    rig.cycles(2)
    rig.run(1.0)
    assert status(rig) is MachineStatus.IDLE


def test_a_broken_machine_says_why() -> None:
    rig = m7(goal=2)
    rig.report(Broken(reason="oil"))
    rig.run(rig.now_s)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert (last.status, last.problem) == (MachineStatus.ERROR, "oil")
    rig.report(Repaired())
    rig.run(rig.now_s)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert (last.status, last.problem) == (MachineStatus.PRODUCING, "")


def test_every_change_of_status_is_a_fact_with_its_reason() -> None:
    rig = m7(NO_HOUSINGS, goal=1)
    rig.stocked("housing", 1)
    rig.cycle()
    changes = [(fact.status, fact.reason) for fact in facts(rig.all, MachineStatusChanged)]
    assert changes == [
        (MachineStatus.STARVED, "material is missing"),
        (MachineStatus.PRODUCING, ""),
        (MachineStatus.IDLE, ""),
    ]


def test_an_idle_machine_beats_every_five_seconds_and_a_working_one_every_second() -> None:
    idle, working = m7(), m7(goal=24)
    for rig, interval_s in ((idle, 5.0), (working, 1.0)):
        rig.run(60.0)
        rig.all.clear()
        rig.run(120.0)
        times_s = [beat.at_s for beat in rig.heartbeats(MachineHeartbeat)]
        gaps_s = [b - a for a, b in pairwise(times_s)]
        assert gaps_s == pytest.approx([interval_s] * len(gaps_s))
        assert len(gaps_s) >= 60 / interval_s - 2


def test_machines_that_start_together_do_not_beat_together() -> None:
    seconds_s = set()
    for machine in PLANT.machines:
        rig = MachineRig(machine)
        rig.start()
        rig.run(20.0)
        seconds_s.add(round(rig.heartbeats(MachineHeartbeat)[-1].at_s % 5.0, 3))
    assert len(seconds_s) > len(PLANT.machines) / 2


def test_a_change_of_status_is_told_at_once() -> None:
    rig = m7()
    rig.run(12.0)
    rig.now_s = 12.1
    rig.report(Broken(reason="oil"))
    assert rig.agent.wake_at_s <= 12.1
    rig.run(12.1)
    assert rig.heartbeats(MachineHeartbeat)[-1].at_s == 12.1


def test_heartbeats_are_numbered_without_a_gap() -> None:
    rig = m7(goal=3)
    rig.run(30.0)
    beats = rig.heartbeats(MachineHeartbeat)
    assert [beat.seq for beat in beats] == list(range(1, len(beats) + 1))
    assert {beat.incarnation for beat in beats} == {1}


def test_the_heartbeat_names_the_contracted_of_every_open_task() -> None:
    rig = supplied_by("ATV2")
    rig.run(rig.now_s)
    [brief] = rig.heartbeats(MachineHeartbeat)[-1].tasks
    assert (brief.task, brief.epoch, brief.primary, brief.secondary) == ("M7-1", 1, "ATV2", "")
    assert (brief.item, brief.quantity, brief.source, brief.destination) == (
        "housing",
        24,
        "S3",
        "M7",
    )


def test_the_heartbeat_tells_that_the_machine_waits() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    rig.run(300.0)
    [brief] = rig.heartbeats(MachineHeartbeat)[-1].tasks
    assert brief.primary == ""
    assert brief.round > 5


def test_the_heartbeat_tells_of_buffers_and_goods() -> None:
    rig = m7(goal=24)
    rig.cycles(3)
    rig.run(2.0)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert [(level.item, level.level, level.capacity) for level in last.buffers] == [
        ("housing", 68, 72),
        ("impeller", 86, 90),
        ("seal-kit", 116, 120),
    ]
    assert [(level.item, level.level, level.capacity) for level in last.goods] == [("pump-p3", 3, 60)]
    assert last.product == "pump-p3"
    [brief] = last.goals
    assert (brief.made, brief.delivered) == (3, 0)


# --- robustness ----------------------------------------------------------------------------------


def test_what_is_not_meant_for_a_machine_is_ignored() -> None:
    rig = m7(goal=2)
    command = VehicleCommand(command="C1", kind=CommandKind.STOP)
    claim = BerthClaimed(berth="CH1", atv="ATV1", battery_frac=0.5, standing=False)
    for message in (
        command,
        claim,
        mhb("M8"),
        rhb("ATV9", 1, 0.0),
        GoalClosed(goal="G9"),
        Superseded(task="M7-1", epoch=2),
        bid(1.0, task="M7-99"),
        goal_bid("G9", 1.0),
    ):
        said = [
            effect for effect in deeds(rig.hear("X", message)) if not published([effect], MachineHeartbeat)
        ]
        assert said == [], message


def test_an_acceptance_of_an_unknown_task_is_released() -> None:
    rig = m7()
    assert sent(rig.hear("ATV2", accepted("M7-99")), Release, to="ATV2")


def test_a_machine_without_a_workcell_is_our_own_bug() -> None:
    class Bodyless(MachineRig):
        def sense(self) -> VehicleState:  # type: ignore[override]
            return None  # type: ignore[return-value]

    with pytest.raises(ProtocolViolation, match="needs a workcell"):
        Bodyless("M7").start()


def test_being_woken_for_nothing_is_harmless() -> None:
    rig = m7(goal=24)
    rig.run(10.0)
    rig.now_s = 10.0
    for _ in range(3):
        rig.wake()
    assert rig.wake() == []


def test_an_agent_leaves_what_it_is_told_as_it_is() -> None:
    rig = m7()
    body = rig.sense()
    before = msgspec.json.encode(body)
    rig.agent.handle(Woke(body), 1.0)
    rig.agent.handle(Reported(Broken(reason="oil")), 2.0)
    rig.agent.handle(Reported(Repaired()), 3.0)
    rig.take_goal("G1", production())
    assert msgspec.json.encode(body) == before
