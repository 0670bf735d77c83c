"""Nobody is hired for what is not there: a machine has its material set aside before it announces anything."""

from __future__ import annotations

from typing import cast

import pytest
from defaults import PLANT
from effects import award_number, facts, published, sent
from m7 import NO_HOUSINGS, docked, handover, m7, supplied_by, transports
from msgspec.structs import replace
from rigs import MachineRig
from spoken import accepted, bid, production, rhb

from dray.messages import (
    Award,
    Brief,
    MachineHeartbeat,
    MaterialWait,
    Phase,
    Reason,
    Resigned,
    Role,
    StockAsked,
    StockFreed,
    StockReserved,
    StockShort,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import CarrierChanged, MachineStatusChanged, TaskClosed
from dray.protocol.liveness.progress import EXCUSED_MAX_S, STALL_S, Progress
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import Effect
from dray.protocol.transports.sourcing import AGAIN_S, ANSWER_S, RENEW_S

TASK = "M7-1"
KEEPING = PLANT.storages_of("housing")
"""Four storages keep housings; M7 lacks them."""


def needing() -> MachineRig:
    """M7 with a goal and without housings; the test answers for the stations."""
    rig = MachineRig("M7", NO_HOUSINGS, stations_answer=False)
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    return rig


def asked(effects: list[Effect], station: str) -> list[StockAsked]:
    return sent(effects, StockAsked, to=station)


def reserved(rig: MachineRig, station: str, *, task: str = TASK, epoch: int = 1) -> list[Effect]:
    return rig.on_message(station, StockReserved(task=task, epoch=epoch, item="housing", quantity=24))


def short(rig: MachineRig, station: str, *, task: str = TASK) -> list[Effect]:
    return rig.on_message(station, StockShort(task=task, epoch=1, item="housing", free=0))


def freed(effects: list[Effect]) -> list[str]:
    """The stations to which something is given back."""
    return [station for station in PLANT.storages if sent(effects, StockFreed, to=station)]


def hired(source: str = "S1") -> MachineRig:
    """M7, whose housings ATV2 fetches; all storages had them."""
    rig = needing()
    for station in KEEPING:
        reserved(rig, station)
    effects = rig.on_message("ATV2", bid(50.0, task=TASK, source=source))
    while not sent(effects, Award, to="ATV2"):
        effects += rig.run(rig.agent.wake_at_s)
    rig.on_message("ATV2", accepted(TASK, number=award_number(effects, "ATV2", TASK)))
    return rig


def surcharge_s(rig: MachineRig) -> float:
    """What is added to the next bid of ATV2."""
    assert isinstance(rig.agent, Machine)
    return rig.agent._flow.tasks.reliability.surcharge_s("ATV2", rig.now_s)


def waits(rig: MachineRig) -> tuple[MaterialWait, ...]:
    rig.run(rig.now_s)
    return rig.heartbeats(MachineHeartbeat)[-1].waits


def test_material_is_asked_for_before_anybody_is() -> None:
    rig = needing()
    assert transports(rig.all) == []
    assert all(asked(rig.all, station) == [StockAsked(TASK, 1, "housing", 24)] for station in KEEPING)
    for station in KEEPING[:-1]:
        assert transports(reserved(rig, station)) == [], "another one may be closer to a vehicle"
    [work] = transports(reserved(rig, KEEPING[-1]))
    assert work.sources == KEEPING


def test_a_task_is_announced_from_the_storages_that_have_it() -> None:
    rig = needing()
    short(rig, KEEPING[0])
    effects = [effect for station in KEEPING[1:] for effect in reserved(rig, station)]
    [work] = transports(effects)
    assert work.sources == KEEPING[1:]
    assert freed(effects) == [KEEPING[0]], "it keeps nobody in its queue who has found another"


def test_a_silent_station_holds_nobody_up_who_can_fetch_elsewhere() -> None:
    rig = needing()
    reserved(rig, KEEPING[1])
    assert transports(rig.run(ANSWER_S - 0.1)) == []
    [work] = transports(rig.run(ANSWER_S))
    assert work.sources == (KEEPING[1],)


def test_nobody_is_hired_for_what_is_nowhere_and_it_is_told_what_is_waited_for() -> None:
    rig = needing()
    for station in KEEPING:
        short(rig, station)
    effects = rig.run(600.0)
    assert transports(rig.all) == []
    [wait] = waits(rig)
    assert (wait.item, wait.quantity, wait.since_s) == ("housing", 24, 0.0)
    assert len(asked(effects, KEEPING[0])) >= 600.0 / AGAIN_S - 1, "the queue forgets who does not ask"


def test_what_is_waited_for_is_told_by_name() -> None:
    rig = needing()
    for station in KEEPING[:-1]:
        short(rig, station)
    rig.run(ANSWER_S)
    [wait] = waits(rig)
    assert (wait.short, wait.silent) == (KEEPING[:-1], (KEEPING[-1],))


def test_it_is_announced_as_soon_as_one_storage_has_it() -> None:
    rig = needing()
    for station in KEEPING:
        short(rig, station)
    rig.run(300.0)
    effects = reserved(rig, KEEPING[2])
    [announced] = published(effects, TaskAnnounced)
    assert announced.work.sources == (KEEPING[2],)
    assert announced.deadline_s > rig.now_s + 60.0, "who begins now has time, too"
    assert freed(effects) == [station for station in KEEPING if station != KEEPING[2]]
    assert waits(rig) == ()


def test_what_was_set_aside_elsewhere_is_given_back_when_somebody_is_hired() -> None:
    assert freed(hired("S2").all) == [station for station in KEEPING if station != "S2"]


def test_a_reservation_is_renewed_until_the_load_is_on_board() -> None:
    rig = hired("S2")
    assert len(asked(rig.run(rig.now_s + 3.0 * RENEW_S), "S2")) >= 2


def test_what_comes_too_late_is_given_back() -> None:
    rig = needing()
    reserved(rig, KEEPING[1])
    rig.run(ANSWER_S)
    assert freed(reserved(rig, KEEPING[0])) == [KEEPING[0]]


def test_a_task_that_is_withdrawn_gives_its_material_back() -> None:
    rig = hired("S2")
    short_of = Resigned(task=TASK, epoch=1, role=Role.PRIMARY, reason=Reason.DOCK_HELD, short="S2")
    effects = rig.on_message("ATV2", short_of)
    assert len(sent(effects, Withdrawn, to="ATV2")) == 1
    assert [fact.outcome for fact in facts(effects, TaskClosed)] == ["withdrawn"]
    assert freed(effects) == ["S2"]
    assert [each.task for each in asked(effects, "S2")] == ["M7-2"], "and it is asked for anew"
    assert transports(effects) == []


def test_who_gives_back_what_its_station_has_promised_is_doubted_and_who_found_nothing_is_not() -> None:
    short_of = Resigned(task=TASK, epoch=1, role=Role.PRIMARY, reason=Reason.DOCK_HELD, short="S2")
    rig = hired("S2")
    rig.on_message("ATV2", short_of)
    assert surcharge_s(rig) > 0.0
    rig = hired("S2")
    short(rig, "S2")
    rig.on_message("ATV2", short_of)
    assert surcharge_s(rig) == 0.0


def test_an_announced_task_whose_material_is_gone_is_withdrawn_while_nobody_is_hired() -> None:
    rig = needing()
    for station in KEEPING:
        reserved(rig, station)
    effects = [effect for station in KEEPING for effect in short(rig, station)]
    assert [fact.outcome for fact in facts(effects, TaskClosed)] == ["withdrawn"]
    assert [each.task for each in asked(effects, "S2")] == ["M7-2"]


def test_a_starving_machine_says_what_it_lacks() -> None:
    rig = needing()
    for station in KEEPING:
        short(rig, station)
    [status] = facts(rig.all, MachineStatusChanged)
    assert status.reason == "material is missing"


def test_what_is_not_needed_any_more_is_not_waited_for() -> None:
    rig = needing()
    for station in KEEPING:
        short(rig, station)
    effects = rig.on_message("STRATEGIST", Withdrawn(task="G1", epoch=1, reason=Reason.NOT_NEEDED))
    assert freed(effects) == list(KEEPING)
    assert waits(rig) == ()


def test_asked_to_leave_it_waits_for_nothing() -> None:
    rig = needing()
    rig.leave()
    assert freed(rig.all) == list(KEEPING)
    assert rig.has_left


def loading(rig: MachineRig, seconds: int, *, answers: bool) -> None:
    """ATV2 stands at the dock of S2 for so long, and beats once a second; the station lives, or does not."""
    task = cast(Machine, rig.agent)._flow.tasks.get(TASK)
    assert task is not None
    task.contract.progress = Progress(rig.now_s + 1e6, STALL_S + 20.0, rig.now_s)
    for _ in range(seconds):
        at_s = rig.now_s + 1.0
        rig.run(at_s)
        beat = rhb("ATV2", int(at_s), at_s, task=TASK, coordinator="M7")
        brief = replace(cast(Brief, beat.task), phase=Phase.LOADING)
        effects = rig.on_message("ATV2", replace(beat, task=brief))
        if answers and asked(effects, "S2"):
            reserved(rig, "S2")


def test_who_stands_before_a_station_that_is_silent_is_not_to_blame() -> None:
    rig = hired("S2")
    loading(rig, 300, answers=False)
    assert facts(rig.all, CarrierChanged) == []


def test_who_stands_before_a_station_that_lives_is() -> None:
    rig = hired("S2")
    loading(rig, 300, answers=True)
    assert [(fact.replaced, fact.reason) for fact in facts(rig.all, CarrierChanged)] == [
        ("ATV2", Reason.STALLED)
    ]


def test_a_silent_station_is_no_excuse_for_ever() -> None:
    rig = hired("S2")
    loading(rig, int(EXCUSED_MAX_S) + 300, answers=False)
    assert [fact.replaced for fact in facts(rig.all, CarrierChanged)][:1] == ["ATV2"]


# --- a station that asks whether its load was fetched ---


@pytest.mark.parametrize(
    ("epoch", "known"),
    [(1, True), (0, False), (2, False)],
    ids=["its epoch", "the epoch of an earlier carrier", "the epoch of one who took over unheard"],
)
def test_a_coordinator_that_is_asked_says_whether_the_load_was_fetched_or_may_have_been(
    epoch: int, *, known: bool
) -> None:
    rig = supplied_by("ATV2")
    rig.on_message("ATV2", docked())
    rig.on_message("ATV2", handover())
    said = rig.on_message("S1", StockReserved("M7-1", epoch, "housing", 24))
    assert sent(said, StockFreed, to="S1") == [StockFreed("M7-1", fetched=True, known=known)]


def test_a_coordinator_whose_task_goes_on_says_that_an_earlier_carrier_may_have_fetched_the_load() -> None:
    rig = supplied_by("ATV2")
    rig.on_message("ATV2", Resigned("M7-1", 1, Role.PRIMARY, Reason.HAS_WORK))
    for _ in range(2):
        said = rig.on_message("S1", StockReserved("M7-1", 1, "housing", 24))
        assert sent(said, StockFreed, to="S1") == [StockFreed("M7-1", fetched=True, epoch=1)]
    assert sent(rig.on_message("S1", StockReserved("M7-1", 2, "housing", 24)), StockFreed) == []


def test_a_coordinator_that_has_withdrawn_a_load_which_somebody_carries_does_not_say_that_it_lies_there() -> (
    None
):
    rig = supplied_by("ATV2")
    said = rig.on_message("ATV2", Resigned("M7-1", 1, Role.PRIMARY, Reason.DOCK_HELD, short="S1"))
    freed = sent(said, StockFreed)
    assert freed
    assert all(each.fetched for each in freed if each.task == "M7-1")


def test_a_coordinator_that_remembers_nothing_does_not_say_that_the_load_lies_there() -> None:
    rig = supplied_by("ATV2")
    said = rig.on_message("S1", StockReserved("M7-99", 1, "housing", 24))
    assert sent(said, StockFreed, to="S1") == [StockFreed("M7-99", fetched=True)]


def test_a_load_for_which_nobody_was_ever_bound_lies_there_still() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    for station in ("S1", "S2", "S6", "S7"):
        rig.on_message(station, StockShort("M7-1", 1, "housing", 0))
    said = rig.on_message("S1", StockReserved("M7-1", 1, "housing", 24))
    assert sent(said, StockFreed, to="S1") == [StockFreed("M7-1")]
