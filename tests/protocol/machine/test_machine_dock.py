"""A production machine lets vehicles in at its dock, and takes what they bring (paper, 3.2)."""

from __future__ import annotations

import pytest
from defaults import PLANT
from dock_parts import dock_parts
from effects import facts, instructed, published, sent
from m7 import FULL, NO_HOUSINGS, docked, handover, hiring, m7, outgoing, supplied_by
from msgspec import UNSET
from rigs import MachineRig
from spoken import rhb

from dray.body import CloseDock, DockReady, OpenDock, StockChanged
from dray.memory import DepartureMemory
from dray.messages import (
    Docked,
    DockHeld,
    DockOpened,
    Handover,
    HandoverAccepted,
    MachineHeartbeat,
    Message,
    Reason,
    Resigned,
    Role,
    Superseded,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import TaskClosed
from dray.messages.heartbeat import DockWait
from dray.messages.keys import Keys
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Effect
from dray.protocol.runtime.life import Life
from dray.protocol.transports.dock_door import NOT_READY, SAFE_WITHIN_S, Door
from dray.protocol.transports.visits import Visits


def alone() -> tuple[Door, Visits, list[Effect]]:
    """The door of a dock that makes itself safe, without an agent; who is waited for at it, and its effects."""
    life = Life()
    subscriptions = HeartbeatSubscriptions(Keys(PLANT.id).atv_heartbeat, life)
    door, visits = dock_parts("m7", subscriptions, life)
    visits.answers = True
    return door, visits, life.effects


HOUSINGS_CAME = StockChanged(item="housing", change=24, seq=1, vehicle="ATV2")

# --- the dock ---------------------------------------------------------------------------------------


def test_the_primary_is_let_in_for_its_load_alone() -> None:
    rig = supplied_by("ATV2")
    effects = rig.on_message("ATV2", docked())
    assert sent(effects, DockOpened, to="ATV2") == [DockOpened(task="M7-1", epoch=1, station="M7")]
    assert instructed(effects, OpenDock) == [OpenDock(vehicle="ATV2", item="housing", quantity=24)]


def test_the_dock_is_open_before_the_vehicle_hears_of_it() -> None:
    effects = supplied_by("ATV2").on_message("ATV2", docked())
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
    effects = rig.on_message(sender, message)
    [superseded] = sent(effects, Superseded, to=sender)
    assert superseded.task == message.task
    assert superseded.epoch == (1 if message.task == "M7-1" else 0)
    assert instructed(effects, OpenDock) == []
    assert facts(effects, TaskClosed) == []


def test_nobody_is_let_in_while_a_carrier_is_still_sought() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    effects = rig.on_message("ATV2", docked())
    assert sent(effects, Superseded, to="ATV2")
    assert instructed(effects, OpenDock) == []


def test_the_dock_is_held_while_the_buffer_has_no_room() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 72)
    effects = rig.on_message("ATV2", docked())
    [held] = sent(effects, DockHeld, to="ATV2")
    assert held.reason == "the buffer is full"
    assert instructed(effects, OpenDock) == []
    rig.stocked("housing", -24)
    assert sent(rig.on_message("ATV2", docked()), DockOpened)


def test_a_dock_that_is_asked_for_twice_is_opened_twice_for_the_same_load() -> None:
    rig = supplied_by("ATV2")
    first, second = rig.on_message("ATV2", docked()), rig.on_message("ATV2", docked())
    assert first == second


def with_a_dock_that_answers() -> MachineRig:
    """M7 without housings, whose dock takes time to open; ATV2 is contracted to bring some (M7-1)."""
    return hiring(MachineRig("M7", NO_HOUSINGS), answers=True)


def test_where_the_dock_takes_time_to_open_a_vehicle_waits_until_it_is_ready() -> None:
    rig = with_a_dock_that_answers()
    effects = rig.on_message("ATV2", docked())
    assert [held.reason for held in sent(effects, DockHeld, to="ATV2")] == [NOT_READY]
    assert instructed(effects, OpenDock)
    assert sent(effects, DockOpened) == []
    assert sent(rig.report(DockReady(vehicle="ATV7")), DockOpened) == []
    assert sent(rig.report(DockReady(vehicle="ATV2")), DockOpened, to="ATV2")
    assert sent(rig.report(DockReady(vehicle="ATV2")), DockOpened) == []


def test_a_vehicle_is_not_sent_away_for_a_dock_that_takes_long_to_open() -> None:
    rig = with_a_dock_that_answers()
    for _ in range(40):
        rig.on_message("ATV2", docked())
        rig.now_s += 5.0
    assert sent(rig.all, Withdrawn) == []
    rig.report(DockReady(vehicle="ATV2"))
    assert sent(rig.on_message("ATV2", handover()), HandoverAccepted, to="ATV2")


def waits(rig: MachineRig) -> list[DockWait]:
    """What its heartbeats have told of a dock that does not get ready, one after the other."""
    told = [beat.dock_wait for beat in rig.heartbeats(MachineHeartbeat)]
    return [each for each, before in zip(told, [UNSET, *told], strict=False) if each and each != before]


def keeps_asking(rig: MachineRig, span_s: float) -> None:
    """ATV2 lives, and asks every five seconds."""
    for second in range(int(span_s)):
        rig.run(rig.now_s + 1.0)
        rig.on_message("ATV2", rhb("ATV2", 100 + int(rig.now_s), rig.now_s, task="M7-1", coordinator="M7"))
        if second % 5 == 4:
            rig.on_message("ATV2", docked())


def test_a_dock_that_does_not_get_ready_in_time_is_told_until_it_is() -> None:
    rig = with_a_dock_that_answers()
    rig.on_message("ATV2", docked())
    since_s = rig.now_s
    patience_s = SAFE_WITHIN_S + max(making.cycle_s for making in PLANT.machines["M7"].makes)
    keeps_asking(rig, patience_s - 5.0)
    assert waits(rig) == []
    keeps_asking(rig, 15.0)
    assert waits(rig) == [DockWait(vehicle="ATV2", since_s=since_s)]
    rig.report(DockReady(vehicle="ATV2"))
    rig.run(rig.now_s + 6.0)
    assert rig.heartbeats(MachineHeartbeat)[-1].dock_wait is UNSET


def test_a_vehicle_that_goes_away_waits_for_no_dock() -> None:
    rig = with_a_dock_that_answers()
    rig.on_message("ATV2", docked())
    rig.on_message("ATV2", Resigned(task="M7-1", epoch=1, role=Role.PRIMARY, reason=Reason.PROBLEM))
    rig.run(rig.now_s + 300.0)
    assert waits(rig) == []


def test_whoever_stands_behind_another_one_waits_from_its_turn_on() -> None:
    door, _, _ = alone()
    for now_s in (0.0, 25.0, 50.0, 75.0, 100.0):
        for vehicle in ("ATV1", "ATV2"):
            if not door.visits.is_inside(vehicle):
                door.open(vehicle, docked(), "housing", 24, now_s, comes=True)
        if now_s == 50.0:
            door.on_ready("ATV1", now_s)
    assert door.wait(110.0) is UNSET
    assert door.wait(111.0) == DockWait(vehicle="ATV2", since_s=50.0)


def test_the_dock_does_not_wait_for_a_vehicle_that_asks_no_more() -> None:
    door, _, effects = alone()
    door.open("ATV1", docked(), "housing", 24, 0.0, comes=False)
    for now_s in range(0, 40, 5):
        assert instructed(effects, CloseDock) == []
        door.open("ATV2", docked(), "housing", 24, float(now_s), comes=True)
    assert instructed(effects, CloseDock) == [CloseDock(vehicle="ATV1")]
    assert not door.is_opening("ATV1")
    assert door.on_ready("ATV2", 40.0)


def test_a_dock_that_opens_for_a_vehicle_that_asks_no_more_is_shut() -> None:
    door, _, effects = alone()
    door.open("ATV1", docked(), "housing", 24, 0.0, comes=False)
    assert not door.on_ready("ATV1", 35.0)
    assert instructed(effects, CloseDock) == [CloseDock(vehicle="ATV1")]
    assert sent(effects, DockOpened) == []


def test_a_vehicle_that_is_not_wanted_any_more_is_not_let_in_by_a_dock_that_opens_late() -> None:
    rig = with_a_dock_that_answers()
    rig.on_message("ATV2", docked())
    effects = rig.on_message("ATV2", Resigned(task="M7-1", epoch=1, role=Role.PRIMARY, reason=Reason.PROBLEM))
    assert instructed(effects, CloseDock)
    assert sent(rig.report(DockReady(vehicle="ATV2")), DockOpened) == []


def test_a_carrier_may_put_goods_down_at_the_warehouse_without_the_machines_dock() -> None:
    rig = m7(goal=24)
    rig.cycles(24)
    [announced] = [each for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(announced.task, "ATV2")
    effects = rig.on_message("ATV2", docked(announced.task, station="DELIVERY"))
    assert sent(effects, DockOpened, to="ATV2")
    assert instructed(effects, OpenDock) == []


def test_a_lot_that_is_not_whole_any_more_is_made_whole_before_it_is_given_out() -> None:
    rig = m7(goal=24)
    rig.cycles(24)
    [announced] = [each for each in published(rig.all, TaskAnnounced) if each.work.goal]  # type: ignore[union-attr]
    rig.hire(announced.task, "ATV2")
    rig.stocked("pump-p3", -1)
    effects = rig.on_message("ATV2", docked(announced.task))
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
        effects = rig.on_message("ATV2", docked())
        assert sent(effects, Withdrawn) == []
        [held] = sent(effects, DockHeld)
        assert held.reason == "the buffer is full"
        rig.now_s += 5.0
    rig.now_s += 1.0
    assert sent(rig.on_message("ATV2", docked()), Withdrawn, to="ATV2")


# --- the handover -----------------------------------------------------------------------------------


def test_a_handover_ends_the_task_and_is_accepted() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 24, "ATV2")
    effects = rig.on_message("ATV2", handover())
    assert sent(effects, HandoverAccepted, to="ATV2") == [HandoverAccepted(task="M7-1", epoch=1)]
    [closed] = facts(effects, TaskClosed)
    assert (closed.task, closed.outcome, closed.carrier) == ("M7-1", "delivered", "ATV2")


def test_handing_over_twice_is_harmless() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 24, "ATV2")
    rig.on_message("ATV2", handover())
    effects = rig.on_message("ATV2", handover())
    assert effects == [effect for effect in effects if sent([effect], HandoverAccepted, to="ATV2")]
    assert len(effects) == 1


def test_a_handover_of_somebody_elses_delivered_task_is_superseded() -> None:
    rig = supplied_by("ATV2")
    rig.stocked("housing", 24, "ATV2")
    rig.on_message("ATV2", handover())
    assert sent(rig.on_message("ATV7", handover()), Superseded, to="ATV7")


def test_what_is_handed_over_is_on_order_no_longer() -> None:
    rig = supplied_by("ATV2")
    rig.run(rig.now_s + 1.0)
    assert rig.reported_stock()[0][0].on_order == 24
    rig.stocked("housing", 24, "ATV2")
    rig.on_message("ATV2", handover())
    rig.run(rig.now_s)
    last = rig.heartbeats(MachineHeartbeat)[-1]
    assert rig.reported_stock()[0][0].on_order == 0
    assert last.tasks == ()


# --- one vehicle, more than once ---


def test_a_dock_at_which_a_vehicle_is_waited_for_stays_open_however_often_it_is_not_wanted() -> None:
    door, visits, out = alone()
    door.open("ATV2", docked(), "housing", 24, 0.0, comes=True)
    door.on_ready("ATV2", 5.0)
    door.shut("ATV2", "M7-1")
    door.shut("ATV2", "M7-1")
    assert instructed(out, CloseDock) == []
    visits.on_carried_away("ATV2")
    assert instructed(out, CloseDock) == [CloseDock("ATV2")]


@pytest.mark.parametrize(("answered", "waits"), [("M7-1", True), ("M7-2", False)])
def test_a_load_of_before_that_is_answered_late_is_not_the_one_that_a_vehicle_is_let_in_for(
    answered: str, waits: bool
) -> None:
    door, visits, _ = alone()
    door.visits.answers, door.visits.counts = False, False
    door.open("ATV2", docked("M7-2"), "housing", 24, 0.0, comes=True)
    door.note_moved(HOUSINGS_CAME, DepartureMemory("ATV2", answered, 1, "housing", 24))
    door.shut("ATV2", "M7-2", DepartureMemory("ATV2", "M7-2", 1, "housing", 24))
    assert visits.waits_for("ATV2") is waits


def test_an_answer_to_no_word_tells_nothing_of_whom_a_body_that_does_not_count_has_let_in() -> None:
    door, visits, _ = alone()
    door.visits.answers, door.visits.counts = False, False
    door.open("ATV2", docked(), "housing", 24, 0.0, comes=True)
    door.note_moved(HOUSINGS_CAME)
    door.shut("ATV2", "M7-1", DepartureMemory("ATV2", "M7-1", 1, "housing", 24))
    assert visits.waits_for("ATV2")


def test_the_end_of_another_transport_shuts_no_dock_in_which_its_vehicle_stands_for_this_one() -> None:
    door, visits, out = alone()
    door.open("ATV2", docked("M7-2"), "housing", 24, 0.0, comes=True)
    door.on_ready("ATV2", 5.0)
    # It had another one before, whose loss is noticed only now.
    door.shut("ATV2", "M7-1", DepartureMemory("ATV2", "M7-1", 1, "housing", 24))
    door.shut("ATV2", "M7-1")  # As what others have fetched, and as what is booked.
    door.close("ATV2", "M7-1")
    assert (instructed(out, CloseDock), visits.waits_for("ATV2")) == ([], False)
    this_one = DepartureMemory("ATV2", "M7-2", 1, "housing", 24)
    door.shut("ATV2", "M7-2", this_one)
    assert (instructed(out, CloseDock), visits.memories()) == ([], (this_one,))


def test_a_vehicle_that_waits_for_the_dock_does_so_whatever_ends_besides() -> None:
    door, _, out = alone()
    door.open("ATV2", docked("M7-2"), "housing", 24, 0.0, comes=True)
    door.shut("ATV2", "M7-1", DepartureMemory("ATV2", "M7-1", 1, "housing", 24))
    door.shut("ATV2", "M7-1")
    door.close("ATV2", "M7-1")
    assert (instructed(out, CloseDock), door.is_opening("ATV2")) == ([], True)
    door.shut("ATV2", "M7-2")
    assert (instructed(out, CloseDock), door.is_opening("ATV2")) == ([CloseDock("ATV2")], False)


@pytest.mark.parametrize("counts", [True, False])
def test_where_the_dock_opens_at_once_the_end_of_another_transport_shuts_it_neither(counts: bool) -> None:
    door, _, out = alone()
    door.visits.answers, door.visits.counts = False, counts
    door.open("ATV2", docked("M7-2"), "housing", 24, 0.0, comes=True)
    door.shut("ATV2", "M7-1")
    door.close("ATV2", "M7-1")
    assert instructed(out, CloseDock) == []
    door.close("ATV2", "M7-2")
    assert instructed(out, CloseDock) == [CloseDock("ATV2")]


@pytest.mark.parametrize(
    ("moved", "waits"),
    [
        (HOUSINGS_CAME, False),
        (StockChanged(item="housing", change=-24, seq=1, vehicle="ATV2"), True),
        (StockChanged(item="shaft", change=24, seq=1, vehicle="ATV2"), True),
    ],
    ids=["its load", "what it took", "another load"],
)
def test_what_a_body_has_counted_of_another_transport_leaves_a_vehicle_inside(
    moved: StockChanged, waits: bool
) -> None:
    door, visits, _ = alone()
    door.open("ATV2", docked("M7-2"), "housing", 24, 0.0, comes=True)
    door.on_ready("ATV2", 5.0)
    door.note_moved(moved)
    door.shut("ATV2", "M7-2", DepartureMemory("ATV2", "M7-2", 1, "housing", 24))
    assert visits.waits_for("ATV2") is waits


def test_who_has_left_after_an_old_transport_still_waits_for_what_it_has_asked_for_since() -> None:
    door, visits, _ = alone()
    door.open("ATV2", docked("M7-1"), "housing", 24, 0.0, comes=True)
    door.on_ready("ATV2", 5.0)
    door.open("ATV2", docked("M7-2"), "housing", 24, 8.0, comes=True)
    door.shut("ATV2", "M7-1", DepartureMemory("ATV2", "M7-1", 1, "housing", 24))
    visits.on_vehicle(rhb("ATV2", 1, 9.0, task="M7-2"), 9.0)
    assert (visits.waits_for("ATV2"), door.is_opening("ATV2")) == (False, True)
    visits.on_carried_away("ATV2")
    assert not door.is_opening("ATV2")
