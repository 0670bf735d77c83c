"""A carrier does not lose a contract on which its coordinator counts."""

from __future__ import annotations

import pytest
from check_kit import TASK, event

from dray.messages import MachineHeartbeat, MachineStatus, Reason, Role, TaskBrief
from dray.messages.fact import CarrierChanged, ContractEnded, MemoryLost, TaskClosed
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution
from dray_sim.checks.standing import Standing
from dray_sim.faults import Crashed, WlanCut

RELEASED = ContractEnded(task=TASK, epoch=1, role=Role.PRIMARY, reason=Reason.RELEASED)


def heartbeat(primary: str = "ATV3", epoch: int = 1) -> MachineHeartbeat:
    """M8 says who carries for it."""
    brief = TaskBrief(
        task=TASK,
        epoch=epoch,
        item="shaft",
        quantity=4,
        source="S1",
        destination="M8",
        deadline_s=100.0,
        primary=primary,
    )
    return MachineHeartbeat(
        machine="M8", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE, tasks=(brief,)
    )


class Watched:
    """The check, and what is said before the carrier gives up."""

    def __init__(self) -> None:
        self.attribution = FaultAttribution(fleet=("ATV3",))
        self.standing = Standing(self.attribution)
        self.standing.on_message(0.0, "M8", "*", heartbeat())

    def ends(self, ended: ContractEnded = RELEASED) -> None:
        self.standing.on_message(10.0, "ATV3", "*", event("ATV3", ended))


@pytest.mark.parametrize("reason", ["released", "superseded"])
def test_a_carrier_that_is_let_go_though_it_is_counted_on_is_noticed(reason: str) -> None:
    with pytest.raises(InvariantBroken, match=r"ATV3 was told .* M8-1 .* M8 counts"):
        Watched().ends(ContractEnded(task=TASK, epoch=1, role=Role.PRIMARY, reason=reason))


def test_a_restart_that_was_over_soon_is_no_reason_and_a_cut_is_one() -> None:
    watched = Watched()
    watched.attribution.begin("F1", Crashed("ATV3"), 1.0)
    watched.attribution.end("F1", 2.0)
    with pytest.raises(InvariantBroken):
        watched.ends()
    watched.attribution.begin("F2", WlanCut("M8"), 3.0)
    watched.ends()


@pytest.mark.parametrize(
    "fact",
    [
        TaskClosed(task=TASK, epoch=1, outcome="withdrawn", carrier="ATV3"),
        CarrierChanged(task=TASK, epoch=2, replaced="ATV3", carrier="ATV1", reason=Reason.SILENT),
        MemoryLost(reason="the disk has failed"),
    ],
    ids=lambda fact: type(fact).__name__,
)
def test_what_its_coordinator_has_ended_or_forgotten_it_does_not_count_on(
    fact: TaskClosed | CarrierChanged | MemoryLost,
) -> None:
    watched = Watched()
    watched.standing.on_message(1.0, "M8", "*", event("M8", fact))
    watched.ends()


@pytest.mark.parametrize(("primary", "epoch"), [("ATV1", 1), ("", 1), ("ATV3", 2)])
def test_another_carrier_or_another_epoch_is_another_contract(primary: str, epoch: int) -> None:
    watched = Watched()
    watched.standing.on_message(1.0, "M8", "*", heartbeat(primary, epoch))
    watched.ends()


def test_who_ends_it_by_itself_loses_nothing() -> None:
    watched = Watched()
    watched.ends(ContractEnded(task=TASK, epoch=1, role=Role.PRIMARY, reason=Reason.HANDED_OVER))
