"""When a carrier fails: what its coordinator does (protocol, "When something fails")."""

from __future__ import annotations

from effects import facts, sent
from spoken import rhb
from transports_rig import TransportsRig, contracted, watched
from watches import BOUND_S

from dray.messages import (
    Confirmed,
    Reason,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import CarrierChanged, TaskClosed
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.liveness.failure_detector import UNNAMED_S
from dray.protocol.takeover.failover import TAKEOVER_TIMEOUT_S
from dray.protocol.takeover.left_aboard import WRITTEN_OFF_AFTER_S
from dray.protocol.transports.transports import RECOVERY_WAIT_S


def takes_over(rig: TransportsRig, atv: str = "ATV1", epoch: int = 2, primary: str = "ATV2") -> None:
    claim = TakenOver(task="T1", epoch=epoch, primary=primary, finish_s=200.0, source="S3")
    rig.transports.on_taken_over(atv, claim, rig.now_s)


def failed() -> TransportsRig:
    """T1 is watched by ATV1; its primary ATV2 has just become silent for the bound."""
    rig = watched()
    rig.run(20.0, "ATV1", "ATV2")
    rig.run(20.0 + BOUND_S + 0.1, "ATV1")
    return rig


def test_the_machine_accepts_a_takeover_and_the_old_carrier_is_superseded() -> None:
    rig = failed()
    takes_over(rig)
    assert (rig.task.primary, rig.task.epoch, rig.task.contract.promised_s) == ("ATV1", 2, 200.0)
    assert sent(rig.out, Confirmed, to="ATV1") == [Confirmed(task="T1", epoch=2)]
    assert sent(rig.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=2)]
    [changed] = facts(rig.out, CarrierChanged)
    assert (changed.replaced, changed.carrier, changed.reason) == ("ATV2", "ATV1", Reason.SILENT)
    assert changed.silent_s >= BOUND_S
    assert rig.task.secondary == ""
    assert rig.asked(Role.SECONDARY)[-1] == "ATV1", "it is not asked to watch itself"


def test_a_takeover_that_is_said_again_is_confirmed_again() -> None:
    rig = failed()
    takes_over(rig)
    takes_over(rig)
    assert len(sent(rig.out, Confirmed, to="ATV1")) == 2
    assert len(facts(rig.out, CarrierChanged)) == 1


def test_two_takeovers_of_one_epoch_leave_one_carrier() -> None:
    rig = failed()
    takes_over(rig, "ATV1")
    takes_over(rig, "ATV4")
    assert rig.task.primary == "ATV1"
    assert sent(rig.out, Superseded, to="ATV4") == [Superseded(task="T1", epoch=2)]


def test_a_takeover_is_refused_while_the_machine_hears_the_primary_itself() -> None:
    rig = watched()
    rig.run(20.0, "ATV1", "ATV2")
    takes_over(rig)
    assert rig.task.primary == "ATV2"
    assert rig.released()[-1] == ("ATV1", Role.PRIMARY)


def test_a_takeover_of_a_closed_task_is_superseded() -> None:
    rig = failed()
    rig.transports.close(rig.task, "delivered")
    takes_over(rig)
    assert sent(rig.out, Superseded, to="ATV1") == [Superseded(task="T1", epoch=2)], "it believes in 2"


def test_when_nobody_takes_over_the_task_is_announced_anew() -> None:
    rig = failed()
    rig.run(rig.now_s + TAKEOVER_TIMEOUT_S + 0.2, "ATV1")
    assert (rig.task.primary, rig.task.epoch) == ("", 2)
    [changed] = facts(rig.out, CarrierChanged)
    assert (changed.replaced, changed.carrier) == ("ATV2", "")
    assert rig.released()[-1] == ("ATV1", Role.SECONDARY)
    takes_over(rig)
    assert rig.task.primary == "", "its takeover time-out is over, and somebody else may have been asked"
    rig.bids(epoch=2, ATV4=50.0)
    rig.run(rig.now_s + 1.0)
    rig.accepts("ATV4", epoch=2)
    assert rig.task.primary == "ATV4"


def asked_to_carry() -> TransportsRig:
    """T1's primary ATV2 was silent already when ATV4 began to watch, so ATV4 has just been asked to carry it."""
    rig = watched()
    rig.run(20.0, "ATV1", "ATV2")
    rig.run(21.0, "ATV1")
    rig.resigns("ATV1")
    rig.bids(role=Role.SECONDARY, ATV4=60.0)
    rig.run(22.5)
    rig.accepts("ATV4", Role.SECONDARY)
    assert (rig.task.primary, rig.task.secondary) == ("ATV2", "ATV4")
    rig.run(20.0 + BOUND_S + 0.1, "ATV4")
    assert rig.asked(Role.PRIMARY)[-1] == "ATV4"
    return rig


def test_a_secondary_that_has_never_heard_the_primary_is_asked_and_not_waited_for() -> None:
    rig = asked_to_carry()
    assert not sent(rig.out, Superseded, to="ATV4")
    rig.accepts("ATV4", epoch=2)
    assert (rig.task.primary, rig.task.epoch) == ("ATV4", 2)


def test_a_takeover_that_crosses_the_award_of_its_epoch_is_the_answer_to_it() -> None:
    rig = asked_to_carry()
    takes_over(rig, "ATV1")
    assert sent(rig.out, Superseded, to="ATV1"), "only whoever is asked may take it"
    takes_over(rig, "ATV4")
    assert sent(rig.out, Confirmed, to="ATV4") == [Confirmed(task="T1", epoch=2)]
    assert not sent(rig.out, Superseded, to="ATV4")
    assert (rig.task.primary, rig.task.epoch, rig.task.contract.promised_s) == ("ATV4", 2, 200.0)
    rig.accepts("ATV4", epoch=2)
    assert rig.task.primary == "ATV4", "its answer to the award changes nothing"


def test_without_a_secondary_it_is_announced_anew_at_once() -> None:
    rig = contracted()
    rig.run(20.0, "ATV2")
    rig.run(20.0 + BOUND_S + 0.2)
    assert rig.task.epoch == 2


def test_a_primary_that_speaks_again_in_time_keeps_its_task() -> None:
    rig = failed()
    rig.run(60.0, "ATV1", "ATV2")
    assert (rig.task.primary, rig.task.epoch) == ("ATV2", 1)


def test_a_primary_that_gives_its_task_back_is_replaced() -> None:
    rig = watched()
    resigned = Resigned(task="T1", epoch=1, role=Role.PRIMARY, reason=Reason.LOAD_GONE)
    rig.transports.on_resigned("ATV2", resigned, rig.now_s)
    assert (rig.task.primary, rig.task.epoch) == ("", 2)


def test_a_primary_that_does_not_name_its_task_has_lost_it() -> None:
    rig = watched()
    rig.run(20.0, "ATV1", "ATV2")
    for seq in range(1000, 1000 + int(UNNAMED_S) + 2):
        rig.now_s += 1.0
        rig.transports.on_heartbeat(rhb("ATV2", seq, rig.now_s), rig.now_s)
    assert rig.task.epoch == 2


def test_a_secondary_that_does_not_name_its_watch_is_replaced() -> None:
    rig = watched()
    rig.run(20.0, "ATV1", "ATV2")
    for seq in range(1000, 1000 + int(UNNAMED_S) + 2):
        rig.now_s += 1.0
        rig.transports.on_heartbeat(rhb("ATV1", seq, rig.now_s), rig.now_s)
    assert rig.task.secondary == ""


def test_goods_on_board_of_a_silent_vehicle_are_waited_for_and_then_given_up() -> None:
    rig = failed()
    rig.task.states.enter(TaskState.IN_TRANSIT)
    rig.run(rig.now_s + TAKEOVER_TIMEOUT_S + 1.0, "ATV1")
    assert (rig.task.primary, rig.task.epoch) == ("ATV2", 1)
    assert rig.task.trouble is Reason.SILENT
    takes_over(rig)
    assert rig.task.primary == "ATV2"
    task = rig.task
    rig.run(rig.now_s + WRITTEN_OFF_AFTER_S)
    assert rig.transports.get("T1") is None
    assert [fact.outcome for fact in facts(rig.out, TaskClosed)] == ["withdrawn"]
    assert sent(rig.out, Withdrawn, to="ATV2")
    assert task.id == "T1"


def test_a_restored_task_goes_on_with_the_carrier_that_names_it() -> None:
    memory = watched().task.memory()
    rig = TransportsRig()
    rig.transports.restore(memory, 0.0)
    rig.run(60.0, "ATV2")
    assert (rig.task.primary, rig.task.epoch) == ("ATV2", 1)


def test_a_restored_task_whose_carrier_is_gone_is_announced_anew() -> None:
    memory = watched().task.memory()
    rig = TransportsRig()
    rig.transports.restore(memory, 0.0)
    rig.run(60.0)
    assert rig.task.epoch >= 2


def test_a_restored_task_without_a_carrier_gets_a_higher_epoch() -> None:
    rig = TransportsRig()
    rig.open()
    restored = TransportsRig()
    restored.transports.restore(rig.task.memory(), 0.0)
    assert restored.task.epoch == 2
    restored.run(RECOVERY_WAIT_S)
    assert [said.epoch for effect in restored.out for said in _announced([effect])] == [2]


def _announced(effects: list[object]) -> list[TaskAnnounced]:
    return [
        effect.message for effect in effects if isinstance(getattr(effect, "message", None), TaskAnnounced)
    ]
