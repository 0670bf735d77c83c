"""Whoever is out of service takes no work and makes nothing; whoever has obeyed to be back may work at once."""

from __future__ import annotations

import pytest
from check_kit import event

from dray.messages import MachineHeartbeat, MachineStatus, OutOfService, Role
from dray.messages.fact import CommandObeyed, ContractTaken, PieceMade
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.people.in_service import InServiceOnly

MADE = PieceMade(goal="G1", product="shaft", made=1)


def out_of_service() -> InServiceOnly:
    """M8 has said that it is out of service, and the piece that was in work has come out."""
    check = InServiceOnly()
    check.on_message(1.0, "M8", "*", heartbeat(1))
    check.on_message(2.0, "M8", "*", event("M8", MADE))
    return check


def heartbeat(seq: int, *, after_work: bool = False) -> MachineHeartbeat:
    """M8 is out of service since second 1, at once or after its work."""
    out = OutOfService(by="op-1", since_s=1.0, after_work=after_work)
    return MachineHeartbeat(
        machine="M8", incarnation=1, seq=seq, at_s=float(seq), status=MachineStatus.IDLE, out_of_service=out
    )


def test_a_machine_that_works_on_is_noticed() -> None:
    with pytest.raises(InvariantBroken, match="M8 works at G1, out of service"):
        out_of_service().on_message(3.0, "M8", "*", event("M8", MADE))


def test_a_machine_that_may_finish_its_work_for_a_while_has_a_piece_in_work_after_that() -> None:
    check = out_of_service()
    check.on_message(3.0, "M8", "*", heartbeat(3, after_work=True))
    check.on_message(4.0, "M8", "*", event("M8", MADE))
    check.on_message(5.0, "M8", "*", event("M8", MADE))
    check.on_message(6.0, "M8", "*", heartbeat(6))
    check.on_message(7.0, "M8", "*", event("M8", MADE))
    with pytest.raises(InvariantBroken, match="M8 works at G1, out of service"):
        check.on_message(8.0, "M8", "*", event("M8", MADE))


@pytest.mark.parametrize("done", [True, False])
def test_a_machine_that_has_obeyed_to_be_back_works_at_once_and_one_that_refused_does_not(done: bool) -> None:
    check = out_of_service()
    check.on_message(3.0, "M8", "*", event("M8", CommandObeyed(command="c1", what="put_in", done=done)))
    taken = event("M8", ContractTaken(task="G2", epoch=1, role=Role.PRIMARY, coordinator="STRAT"))
    if done:
        check.on_message(3.0, "M8", "*", taken)
        check.on_message(4.0, "M8", "*", event("M8", MADE))
        check.on_message(5.0, "M8", "*", event("M8", MADE))
    else:
        with pytest.raises(InvariantBroken, match="M8 took G2"):
            check.on_message(3.0, "M8", "*", taken)
