"""When a carrier fails: what its coordinator does (protocol, "When something fails")."""

from __future__ import annotations

from effects import facts, sent
from office import Office, contracted, watched
from spoken import rhb
from watches import BOUND_S

from dray.messages import (
    Confirmed,
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
from dray.protocol.machine.transports.transports import ADOPT_S
from dray.protocol.takeover.failover import LOST_IN_TRANSIT_S, TAKEOVER_TIMEOUT_S


def takes_over(office: Office, atv: str = "ATV1", epoch: int = 2, primary: str = "ATV2") -> None:
    claim = TakenOver(task="T1", epoch=epoch, primary=primary, finish_s=200.0, source="S3")
    office.desk.on_taken_over(atv, claim, office.now_s)


def failed() -> Office:
    """T1 is watched by ATV1; its primary ATV2 has just become silent for the bound."""
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    office.run(20.0 + BOUND_S + 0.1, "ATV1")
    return office


def test_the_machine_accepts_a_takeover_and_the_old_carrier_is_superseded() -> None:
    office = failed()
    takes_over(office)
    assert (office.task.primary, office.task.epoch, office.task.contract.promised_s) == ("ATV1", 2, 200.0)
    assert sent(office.out, Confirmed, to="ATV1") == [Confirmed(task="T1", epoch=2)]
    assert sent(office.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=2)]
    [changed] = facts(office.out, CarrierChanged)
    assert (changed.replaced, changed.carrier, changed.reason) == ("ATV2", "ATV1", "silent")
    assert changed.silent_s >= BOUND_S
    assert office.task.secondary == ""
    assert office.asked(Role.SECONDARY)[-1] == "ATV1", "it is not asked to watch itself"


def test_a_takeover_that_is_said_again_is_confirmed_again() -> None:
    office = failed()
    takes_over(office)
    takes_over(office)
    assert len(sent(office.out, Confirmed, to="ATV1")) == 2
    assert len(facts(office.out, CarrierChanged)) == 1


def test_two_takeovers_of_one_epoch_leave_one_carrier() -> None:
    office = failed()
    takes_over(office, "ATV1")
    takes_over(office, "ATV4")
    assert office.task.primary == "ATV1"
    assert sent(office.out, Superseded, to="ATV4") == [Superseded(task="T1", epoch=2)]


def test_a_takeover_is_refused_while_the_machine_hears_the_primary_itself() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    takes_over(office)
    assert office.task.primary == "ATV2"
    assert office.released()[-1] == ("ATV1", Role.PRIMARY)


def test_a_takeover_of_a_closed_task_is_superseded() -> None:
    office = failed()
    office.desk.close(office.task, "delivered")
    takes_over(office)
    assert sent(office.out, Superseded, to="ATV1") == [Superseded(task="T1", epoch=2)], "it believes in 2"


def test_when_nobody_takes_over_the_task_is_announced_anew() -> None:
    office = failed()
    office.run(office.now_s + TAKEOVER_TIMEOUT_S + 0.2, "ATV1")
    assert (office.task.primary, office.task.epoch) == ("", 2)
    [changed] = facts(office.out, CarrierChanged)
    assert (changed.replaced, changed.carrier) == ("ATV2", "")
    assert office.released()[-1] == ("ATV1", Role.SECONDARY)
    takes_over(office)
    assert office.task.primary == "", "its grace is over, and somebody else may have been asked"
    office.bids(epoch=2, ATV4=50.0)
    office.run(office.now_s + 1.0)
    office.accepts("ATV4", epoch=2)
    assert office.task.primary == "ATV4"


def test_a_secondary_that_has_never_heard_the_primary_is_asked_and_not_waited_for() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    office.run(21.0, "ATV1")
    office.resigns("ATV1")
    office.bids(role=Role.SECONDARY, ATV4=60.0)
    office.run(22.5)
    office.accepts("ATV4", Role.SECONDARY)
    assert (office.task.primary, office.task.secondary) == ("ATV2", "ATV4"), (
        "it watches somebody who is silent already"
    )
    office.run(20.0 + BOUND_S + 0.1, "ATV4")
    assert office.asked(Role.PRIMARY)[-1] == "ATV4"
    assert not any(effect.to == "ATV4" for effect in office.out if sent([effect], Superseded))
    office.accepts("ATV4", epoch=2)
    assert (office.task.primary, office.task.epoch) == ("ATV4", 2)


def test_without_a_secondary_it_is_announced_anew_at_once() -> None:
    office = contracted()
    office.run(20.0, "ATV2")
    office.run(20.0 + BOUND_S + 0.2)
    assert office.task.epoch == 2


def test_a_primary_that_speaks_again_in_time_keeps_its_task() -> None:
    office = failed()
    office.run(60.0, "ATV1", "ATV2")
    assert (office.task.primary, office.task.epoch) == ("ATV2", 1)


def test_a_primary_that_gives_its_task_back_is_replaced() -> None:
    office = watched()
    resigned = Resigned(task="T1", epoch=1, role=Role.PRIMARY, reason="its load was taken off")
    office.desk.on_resigned("ATV2", resigned, office.now_s)
    assert (office.task.primary, office.task.epoch) == ("", 2)


def test_a_primary_that_does_not_name_its_task_has_lost_it() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    for seq in range(1000, 1000 + int(UNNAMED_S) + 2):
        office.now_s += 1.0
        office.desk.on_heartbeat(rhb("ATV2", seq, office.now_s), office.now_s)
    assert office.task.epoch == 2


def test_a_secondary_that_does_not_name_its_watch_is_replaced() -> None:
    office = watched()
    office.run(20.0, "ATV1", "ATV2")
    for seq in range(1000, 1000 + int(UNNAMED_S) + 2):
        office.now_s += 1.0
        office.desk.on_heartbeat(rhb("ATV1", seq, office.now_s), office.now_s)
    assert office.task.secondary == ""


def test_goods_on_board_of_a_silent_vehicle_are_waited_for_and_then_given_up() -> None:
    office = failed()
    office.task.states.enter(TaskState.IN_TRANSIT)
    office.run(office.now_s + TAKEOVER_TIMEOUT_S + 1.0, "ATV1")
    assert (office.task.primary, office.task.epoch) == ("ATV2", 1)
    assert "with the load on board" in office.task.trouble
    takes_over(office)
    assert office.task.primary == "ATV2"
    task = office.task
    office.run(office.now_s + LOST_IN_TRANSIT_S)
    assert office.desk.get("T1") is None
    assert [fact.outcome for fact in facts(office.out, TaskClosed)] == ["withdrawn"]
    assert sent(office.out, Withdrawn, to="ATV2")
    assert task.id == "T1"


def test_a_restored_task_goes_on_with_the_carrier_that_names_it() -> None:
    memory = watched().task.memory()
    office = Office()
    office.desk.restore(memory, 0.0)
    office.run(60.0, "ATV2")
    assert (office.task.primary, office.task.epoch) == ("ATV2", 1)


def test_a_restored_task_whose_carrier_is_gone_is_announced_anew() -> None:
    memory = watched().task.memory()
    office = Office()
    office.desk.restore(memory, 0.0)
    office.run(60.0)
    assert office.task.epoch >= 2


def test_a_restored_task_without_a_carrier_gets_a_higher_epoch() -> None:
    office = Office()
    office.open()
    restored = Office()
    restored.desk.restore(office.task.memory(), 0.0)
    assert restored.task.epoch == 2
    restored.run(ADOPT_S)
    assert [said.epoch for effect in restored.out for said in _announced([effect])] == [2]


def _announced(effects: list[object]) -> list[TaskAnnounced]:
    return [
        effect.message for effect in effects if isinstance(getattr(effect, "message", None), TaskAnnounced)
    ]
