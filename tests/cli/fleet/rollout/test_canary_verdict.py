"""The verdict on a canary, by what others say: facts and heartbeats in, a verdict out."""

from __future__ import annotations

import msgspec
import pytest

from dray.cli.fleet.rollout.canary_verdict import AtvCanary, Canary, MachineCanary, StrategistCanary
from dray.messages import (
    AnyFact,
    AtvHeartbeat,
    AtvStatus,
    CommandKind,
    Event,
    MachineHeartbeat,
    MachineStatus,
    Pose,
    Reason,
    Role,
    TransportCost,
)
from dray.messages.fact import (
    AwardAnswered,
    BidReceived,
    CarrierChanged,
    CommandObeyed,
    ContractEnded,
    ContractTaken,
    GoalContracted,
    GoalLost,
    TaskClosed,
)
from dray.messages.keys import STRATEGIST

NEW, LATE_S = "2.0", 10.0
PROMISED_S = 100.0
COST = TransportCost(empty_way_s=1.0, loaded_way_s=1.0, energy_s=0.0, suitability_s=0.0)


def beat(atv: str = "ATV1", life: int = 2, software: str = NEW) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=atv,
        incarnation=life,
        seq=1,
        at_s=0.0,
        status=AtvStatus.IDLE,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="N1",
        speed_mps=0.0,
        battery_frac=1.0,
        software=software,
    )


def tell(canary: Canary, agent: str, *facts: AnyFact, at_s: float = 50.0) -> None:
    for number, fact in enumerate(facts, 1):
        canary.on_message(agent, Event(agent=agent, incarnation=1, number=number, at_s=at_s, fact=fact))


def vehicle(tasks: int = 1) -> AtvCanary:
    """ATV1 as a canary, which was heard in its second life."""
    canary = AtvCanary("ATV1", NEW, tasks, 1, LATE_S)
    canary.on_message("ATV1", beat())
    assert canary.joined
    return canary


def hired(task: str = "M1-1", by: str = "ATV1", epoch: int = 1) -> tuple[AnyFact, ...]:
    """A machine takes a vehicle's bid."""
    return (
        BidReceived(
            task=task,
            epoch=epoch,
            role=Role.PRIMARY,
            round=1,
            bidder=by,
            cost=COST,
            total_s=2.0,
            finish_s=PROMISED_S,
        ),
        AwardAnswered(task=task, epoch=epoch, role=Role.PRIMARY, bidder=by, answer="accepted"),
    )


def closed(task: str = "M1-1", carrier: str = "ATV1", outcome: str = "delivered") -> TaskClosed:
    return TaskClosed(task=task, epoch=1, outcome=outcome, carrier=carrier, promised_s=PROMISED_S)


def changed(reason: str, task: str = "M1-1") -> CarrierChanged:
    return CarrierChanged(task=task, epoch=2, replaced="ATV1", carrier="ATV2", reason=reason)


def test_a_vehicle_passes_by_tasks_that_its_coordinators_closed_in_time() -> None:
    canary = vehicle(tasks=2)
    tell(canary, "M1", *hired(), closed())
    assert (canary.done, canary.passed) == (1, False)
    tell(canary, "M2", *hired("M2-1"), closed("M2-1"), at_s=PROMISED_S + LATE_S)
    assert (canary.done, canary.passed, canary.failure) == (2, True, "")


def test_its_own_word_counts_for_nothing() -> None:
    canary = vehicle()
    ended = ContractEnded(task="M1-1", epoch=1, role=Role.PRIMARY, reason=Reason.HANDED_OVER)
    tell(canary, "ATV1", ended)
    assert canary.done == 0


def test_what_others_do_and_what_its_last_life_had_begun_counts_for_nothing() -> None:
    canary = vehicle()
    tell(
        canary,
        "M1",
        *hired(by="ATV2"),
        closed(carrier="ATV2"),
        closed("M1-7"),
        changed(Reason.SILENT, "M1-8"),
    )
    assert (canary.done, canary.failure) == (0, "")


def test_what_was_said_before_it_was_there_is_about_its_last_life() -> None:
    canary = AtvCanary("ATV1", NEW, 1, 1, LATE_S)
    canary.on_message("ATV1", beat(life=1, software="1.0"))
    tell(canary, "M1", *hired(), changed(Reason.SILENT))
    assert (canary.joined, canary.failure) == (False, "")


@pytest.mark.parametrize("reason", [Reason.SILENT, Reason.IN_ERROR, "its load was taken off"])
def test_a_task_that_had_to_be_taken_from_it_fails_it(reason: str) -> None:
    canary = vehicle()
    tell(canary, "M1", *hired(), changed(reason))
    assert canary.failure == f"M1-1 had to be taken from it: {reason}"


def test_a_late_task_fails_it_whether_it_was_delivered_in_the_end_or_is_under_way() -> None:
    delivered, under_way = vehicle(), vehicle()
    late_s = PROMISED_S + LATE_S + 1.0
    tell(delivered, "M1", *hired())
    tell(delivered, "M1", closed(), at_s=late_s)
    assert "M1-1 was delivered 11 s after its promise" in delivered.failure
    tell(under_way, "M1", *hired())
    under_way.look(late_s - 1.0)
    assert not under_way.failure
    under_way.look(late_s)
    assert "M1-1 is not done 11 s after" in under_way.failure


@pytest.mark.parametrize(
    "end", [closed(outcome="withdrawn"), closed(carrier="ATV2")], ids=["withdrawn", "closed by another"]
)
def test_what_its_coordinator_takes_back_counts_neither_way(end: TaskClosed) -> None:
    canary = vehicle()
    tell(canary, "M1", *hired(), end)
    canary.look(1e9)
    assert (canary.done, canary.failure) == (0, "")


def test_a_persons_stop_is_no_fault_of_it() -> None:
    canary = vehicle()
    tell(canary, "M1", *hired())
    tell(canary, "ATV1", CommandObeyed(command="C1", what=CommandKind.STOP.value, done=True))
    tell(canary, "M1", changed(Reason.IN_ERROR))
    canary.look(1e9)
    assert canary.failure == ""


def test_a_stop_that_it_refused_excuses_nothing() -> None:
    canary = vehicle()
    tell(canary, "M1", *hired())
    tell(canary, "ATV1", CommandObeyed(command="C1", what=CommandKind.STOP.value, done=False))
    tell(canary, "M1", changed(Reason.SILENT))
    assert canary.failure


def test_a_task_that_it_takes_over_is_its_own_from_then_on() -> None:
    canary = vehicle()
    taken = CarrierChanged(task="M1-1", epoch=2, replaced="ATV2", carrier="ATV1", reason=Reason.SILENT)
    tell(canary, "M1", taken, closed())
    assert canary.passed


def test_another_version_than_it_should_have_fails_it() -> None:
    canary = AtvCanary("ATV1", NEW, 1, 1, LATE_S)
    canary.on_message("ATV1", beat(software="1.0"))
    assert canary.failure == "it says that it runs 1.0, not 2.0"


def test_a_second_life_within_its_probation_fails_it() -> None:
    canary = vehicle()
    canary.on_message("ATV1", beat(life=3))
    assert canary.failure == "it was started again"


def test_the_first_reason_is_kept() -> None:
    canary = vehicle()
    canary.fail("one")
    canary.fail("two")
    assert canary.failure == "one"


def machine(tasks: int = 1) -> MachineCanary:
    canary = MachineCanary("M1", NEW, tasks, 1, LATE_S)
    heard = MachineHeartbeat(
        machine="M1", incarnation=2, seq=1, at_s=0.0, status=MachineStatus.IDLE, software=NEW
    )
    canary.on_message("M1", heard)
    assert canary.joined
    return canary


def test_a_machine_passes_by_what_the_vehicles_that_it_has_hired_hand_over() -> None:
    canary = machine(tasks=2)
    taken = ContractTaken(task="M1-1", epoch=1, role=Role.PRIMARY, coordinator="M1")
    ended = ContractEnded(task="M1-1", epoch=1, role=Role.PRIMARY, reason=Reason.HANDED_OVER)
    tell(canary, "ATV1", taken, ended, ended)
    tell(canary, "ATV2", msgspec.structs.replace(ended, task="M2-1"))
    assert canary.done == 1
    tell(canary, "ATV2", msgspec.structs.replace(taken, role=Role.SECONDARY, task="M1-2"))
    tell(canary, "ATV2", msgspec.structs.replace(ended, task="M1-2"))
    assert canary.done == 1
    tell(canary, "ATV2", msgspec.structs.replace(taken, task="M1-3"))
    tell(canary, "ATV2", msgspec.structs.replace(ended, task="M1-3"))
    assert canary.passed


def test_what_a_successor_hands_over_counts_though_the_contract_before_ends_later() -> None:
    canary = machine()
    first = ContractTaken(task="M1-1", epoch=1, role=Role.PRIMARY, coordinator="M1")
    tell(canary, "ATV1", first)
    tell(canary, "ATV2", msgspec.structs.replace(first, epoch=2))
    ended = ContractEnded(task="M1-1", epoch=1, role=Role.PRIMARY, reason=Reason.SUPERSEDED)
    tell(canary, "ATV1", ended)
    assert canary.done == 0
    tell(canary, "ATV2", msgspec.structs.replace(ended, epoch=2, reason=Reason.HANDED_OVER))
    assert canary.passed


def test_a_machine_fails_by_a_goal_that_it_took_and_others_had_to_get() -> None:
    lost = GoalLost(goal="G1", machine="M1", arrived=0, successor="G2")
    canary = machine()
    tell(canary, STRATEGIST, lost)
    assert not canary.failure, "of its last life"
    contracted = GoalContracted(
        goal="G1", order="O1", item=0, product="P1", quantity=1, machine="M1", finish_s=1.0
    )
    tell(canary, STRATEGIST, contracted, lost)
    assert canary.failure == "its goal G1 had to be given to others"


def test_a_strategist_passes_by_goals_that_machines_take_from_it() -> None:
    canary = StrategistCanary(STRATEGIST, NEW, 1, 0, LATE_S)
    taken = ContractTaken(task="G1", epoch=1, role=Role.PRIMARY, coordinator=STRATEGIST)
    tell(canary, "M1", taken)
    assert not canary.passed, "nobody has seen it yet"
    canary.note_present()
    tell(canary, "M1", taken)
    assert canary.passed
