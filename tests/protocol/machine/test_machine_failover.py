"""A machine whose carriers fail, and one that was started again (protocol, "When something fails")."""

from __future__ import annotations

import msgspec
from defaults import KEYS, PLANT
from effects import award_number, committed, facts, instructed, listening, published, sent
from m7 import hiring
from rigs import MachineRig
from spoken import accepted, bid, production, rhb

from dray.body import CloseDock, OpenDock
from dray.memory import Memory
from dray.messages import (
    Award,
    Brief,
    Docked,
    DockOpened,
    Handover,
    HandoverAccepted,
    MachineHeartbeat,
    Phase,
    Reason,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    TaskAnnounced,
    Transport,
)
from dray.messages.fact import CarrierChanged, TaskClosed
from dray.protocol.liveness.suspicion import LATENESS_MAX_S
from dray.protocol.runtime.events import Woke
from dray.protocol.transports.transports import RECOVERY_WAIT_S

STOCK = {"housing": 0, "impeller": 90, "seal-kit": 120}
GONE_S = LATENESS_MAX_S + 60.0
"""Silence by which any vehicle is given up."""


def supplied(stock: dict[str, int] = STOCK, goal: int = 24) -> MachineRig:
    """M7 without housings; ATV2 is contracted to bring some (M7-1)."""
    return hiring(MachineRig("M7", stock), goal=goal)


def with_goods() -> tuple[MachineRig, str]:
    """M7 with a lot of pumps for which ATV2 is contracted; and the name of that task."""
    rig = MachineRig("M7", {"housing": 72, "impeller": 90, "seal-kit": 120})
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    rig.cycles(24)
    [task] = [each.task for each in published(rig.all, TaskAnnounced) if goods(each)]
    rig.hire(task, "ATV2")
    rig.on_message("ATV2", Docked(task=task, epoch=1, station="M7"))
    return rig, task


def goods(announced: TaskAnnounced) -> bool:
    return isinstance(announced.work, Transport) and bool(announced.work.goal)


def take_over(rig: MachineRig, task: str = "M7-1", atv: str = "ATV1") -> None:
    rig.on_message(atv, accepted(task, role=Role.SECONDARY, number=watch(rig, atv, task)))
    # Nothing was ever heard of ATV2, and the machine is about to find that out itself.
    rig.run(rig.now_s + LATENESS_MAX_S + 3.0)
    rig.on_message(atv, TakenOver(task=task, epoch=2, primary="ATV2", finish_s=rig.now_s + 90.0, source="S6"))


def watch(rig: MachineRig, atv: str, task: str) -> int:
    """Let a vehicle bid for a watch, and be asked; the number of that award."""
    effects = rig.on_message(atv, bid(50.0, task=task, role=Role.SECONDARY))
    while not sent(effects, Award, to=atv):
        effects += rig.run(rig.agent.wake_at_s)
    return award_number(effects, atv, task, Role.SECONDARY)


def carrier(rig: MachineRig, task: str = "M7-1") -> tuple[str, int]:
    rig.run(rig.now_s)
    [brief] = [each for each in rig.heartbeats(MachineHeartbeat)[-1].tasks if each.task == task]
    return brief.primary, brief.epoch


# --- who was held up itself --------------------------------------------------------------------------


def test_a_machine_that_was_held_up_itself_gives_its_carrier_the_time_that_it_could_not_hear() -> None:
    rig = supplied()
    rig.on_message("ATV2", rhb("ATV2", 1, rig.now_s, task="M7-1", coordinator="M7"))
    rig.now_s += 30.0
    rig.handle(Woke(rig.sense(), late_s=29.0))
    rig.run(rig.now_s + 2.0)
    assert carrier(rig) == ("ATV2", 1)
    rig.run(rig.now_s + LATENESS_MAX_S + 5.0)
    assert carrier(rig)[1] == 2


# --- announced again ---------------------------------------------------------------------------------


def test_what_was_given_back_is_announced_with_all_the_time_that_its_rounds_had_come_to() -> None:
    rig = MachineRig("M7", STOCK)
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    while last_announced(rig).round < 8:
        rig.run(rig.agent.wake_at_s)
    offered_s = last_announced(rig).deadline_s - rig.now_s
    rig.hire("M7-1", "ATV2")
    rig.on_message("ATV2", Resigned(task="M7-1", epoch=1, role=Role.PRIMARY, reason=Reason.PROBLEM))
    while last_announced(rig).epoch == 1:
        rig.run(rig.agent.wake_at_s)
    assert (last_announced(rig).epoch, last_announced(rig).round) == (2, 1)
    assert last_announced(rig).deadline_s - rig.now_s > 0.95 * offered_s


def last_announced(rig: MachineRig) -> TaskAnnounced:
    return next(each for each in reversed(published(rig.all, TaskAnnounced)) if each.task == "M7-1")


# --- the fence -----------------------------------------------------------------------------------


def test_the_dock_opens_for_the_new_carrier_alone() -> None:
    rig = supplied()
    take_over(rig)
    assert carrier(rig) == ("ATV1", 2)
    effects = rig.on_message("ATV2", Docked(task="M7-1", epoch=1, station="M7"))
    assert sent(effects, Superseded, to="ATV2") == [Superseded(task="M7-1", epoch=2)]
    assert instructed(effects, OpenDock) == []
    effects = rig.on_message("ATV1", Docked(task="M7-1", epoch=2, station="M7"))
    assert len(sent(effects, DockOpened, to="ATV1")) == 1
    assert [opening.vehicle for opening in instructed(effects, OpenDock)] == ["ATV1"]


def test_a_handover_of_an_earlier_epoch_counts_for_nothing() -> None:
    rig = supplied()
    take_over(rig)
    effects = rig.on_message("ATV2", Handover(task="M7-1", epoch=1, quantity=24))
    assert sent(effects, HandoverAccepted) == []
    assert facts(rig.all, TaskClosed) == []
    assert (
        len(sent(rig.on_message("ATV1", Handover(task="M7-1", epoch=2, quantity=24)), HandoverAccepted)) == 1
    )


def test_the_dock_is_shut_behind_a_carrier_that_was_replaced() -> None:
    rig = supplied()
    rig.on_message("ATV2", Docked(task="M7-1", epoch=1, station="M7"))
    take_over(rig)
    assert [closing.vehicle for closing in instructed(rig.all, CloseDock)] == ["ATV2"]


def test_a_carrier_that_dies_after_it_has_unloaded_has_delivered() -> None:
    rig = supplied()
    rig.on_message("ATV2", Docked(task="M7-1", epoch=1, station="M7"))
    rig.stocked("housing", 24, "ATV2")
    take_over(rig)
    assert sent(rig.all, Superseded, to="ATV1") == [Superseded(task="M7-1", epoch=2)]
    [closed] = facts(rig.all, TaskClosed)
    assert (closed.outcome, closed.carrier) == ("delivered", "ATV2")
    assert facts(rig.all, CarrierChanged) == []
    # It lives after all, and says so.
    assert (
        len(sent(rig.on_message("ATV2", Handover(task="M7-1", epoch=1, quantity=24)), HandoverAccepted)) == 1
    )


# --- goods ---------------------------------------------------------------------------------------


def test_goods_that_a_person_brings_back_are_sent_again() -> None:
    rig, task = with_goods()
    rig.stocked("pump-p3", -24, "ATV2")
    rig.run(rig.now_s + GONE_S)
    assert carrier(rig, task) == ("ATV2", 1)
    rig.stocked("pump-p3", 24)
    assert carrier(rig, task) == ("", 2)
    assert published(rig.all, TaskAnnounced)[-1].epoch == 2


def test_goods_that_leave_with_somebody_else_are_made_anew() -> None:
    rig, _ = with_goods()
    rig.stock |= {"housing": 72, "impeller": 90, "seal-kit": 120}
    rig.run(rig.now_s + 5.0)
    assert not rig.is_cycling
    rig.stocked("pump-p3", -24, "ATV9")
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["withdrawn"]
    assert rig.is_cycling


# --- another life --------------------------------------------------------------------------------


def reborn(rig: MachineRig, memory: Memory, **stock: int) -> MachineRig:
    again = MachineRig("M7", rig.stock | stock, incarnation=2)
    again.memory, again.now_s = memory, rig.now_s
    again.start()
    return again


def notes(rig: MachineRig) -> Memory:
    return committed(rig.all)


def names(rig: MachineRig, atv: str, task: str, *, epoch: int = 1, item: str = "housing") -> None:
    """A vehicle says that it carries a task of M7."""
    brief = Brief(
        task=task,
        epoch=epoch,
        role=Role.PRIMARY,
        coordinator="M7",
        phase=Phase.CARRYING,
        item=item,
        quantity=24,
        due_s=rig.now_s + 60.0,
    )
    heartbeat = rhb(atv, int(rig.now_s * 10) + 1, rig.now_s, task=task, coordinator="M7")
    rig.on_message(atv, msgspec.structs.replace(heartbeat, task=brief))


def test_a_machine_that_was_started_again_listens_to_all_vehicles_for_a_while() -> None:
    again = reborn(supplied(), {})
    assert KEYS.all_atv_heartbeats in listening(again.all)
    again.run(again.now_s + RECOVERY_WAIT_S)
    assert KEYS.all_atv_heartbeats not in listening(again.all)


def test_a_carrier_that_its_notes_name_goes_on() -> None:
    rig = supplied()
    again = reborn(rig, notes(rig))
    names(again, "ATV2", "M7-1")
    assert carrier(again) == ("ATV2", 1)
    assert len(sent(again.on_message("ATV2", Docked(task="M7-1", epoch=1, station="M7")), DockOpened)) == 1


def test_an_award_that_was_accepted_while_it_was_away_stands() -> None:
    rig = MachineRig("M7", STOCK)
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    again = reborn(rig, notes(rig))
    assert carrier(again) == ("", 2)
    names(again, "ATV2", "M7-1")
    assert carrier(again) == ("ATV2", 1)
    again.run(again.now_s + 3.0)
    assert [each for each in published(again.all, TaskAnnounced) if each.role is Role.PRIMARY] == []


def test_a_task_that_no_vehicle_names_is_announced_anew() -> None:
    rig = MachineRig("M7", STOCK)
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    again = reborn(rig, notes(rig))
    again.run(again.now_s + RECOVERY_WAIT_S)
    [announced] = [each for each in published(again.all, TaskAnnounced) if each.task == "M7-1"]
    assert announced.epoch == 2


def test_a_machine_that_has_lost_its_notes_recovers_who_carries_material_for_it() -> None:
    again = reborn(supplied(), {})
    names(again, "ATV2", "M7-1")
    assert carrier(again) == ("ATV2", 1)
    assert len(sent(again.on_message("ATV2", Docked(task="M7-1", epoch=1, station="M7")), DockOpened)) == 1


def test_what_is_no_material_of_this_machine_is_not_recovered() -> None:
    again = reborn(supplied(), {})
    other = next(material for material in PLANT.materials if material not in PLANT.materials_of("M7"))
    names(again, "ATV2", "M7-1", item=other)
    assert again.heartbeats(MachineHeartbeat) == [] or again.heartbeats(MachineHeartbeat)[-1].tasks == ()


def test_a_machine_with_its_notes_recovers_nothing_that_it_has_closed() -> None:
    rig = supplied()
    rig.on_message("ATV2", Handover(task="M7-1", epoch=1, quantity=24))
    again = reborn(rig, notes(rig), housing=24)
    names(again, "ATV2", "M7-1")
    effects = again.on_message("ATV2", Docked(task="M7-1", epoch=1, station="M7"))
    assert sent(effects, Superseded, to="ATV2") == [Superseded(task="M7-1", epoch=0)]


def test_goods_that_left_while_it_was_away_and_nobody_has_are_made_anew() -> None:
    rig, _ = with_goods()
    rig.stock["pump-p3"] = 0
    again = reborn(rig, notes(rig), housing=72)
    again.run(again.now_s + RECOVERY_WAIT_S)
    assert again.is_cycling


def test_a_lot_that_left_while_another_piece_was_made_is_made_anew() -> None:
    rig, _ = with_goods()
    rig.stock["pump-p3"] = 1
    again = reborn(rig, notes(rig), housing=72)
    again.run(again.now_s + RECOVERY_WAIT_S)
    again.cycles(23)
    assert not again.is_cycling
