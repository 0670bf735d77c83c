"""Plain transports: the station of a storage has brought to it what somebody asks for, once, whatever is lost on the way."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from closed import closure, closures
from defaults import PLANT
from effects import award_number, committed, facts, instructed, published, sent
from rigs import MachineRig
from seals import granted
from spoken import accepted, bid, rhb
from storage_rig import ORDER, TASK, StorageRig, restarted, started

from dray.body import CloseDock, OpenDock, StockChanged
from dray.messages import (
    Award,
    Brief,
    CallState,
    CommandAnswered,
    CommandRefusal,
    Docked,
    DockOpened,
    Handover,
    HandoverAccepted,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    Phase,
    Reason,
    Role,
    StationHeartbeat,
    StockAsked,
    StockReserved,
    TaskAnnounced,
    TransportAnswered,
    TransportCancelled,
    TransportRefusal,
    TransportState,
    TransportWait,
    Withdrawn,
)
from dray.messages.fact import TransportProgressed
from dray.plant import Plant
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import Effect, Ignore, Send
from dray.protocol.transports.called import OPEN_MAX
from dray.protocol.transports.receiving import COUNT_S
from dray.protocol.transports.sourcing import RENEW_S


def test_what_is_asked_for_is_set_aside_fetched_counted_and_told() -> None:
    rig = started()
    assert rig.asks() == TransportAnswered("T-1", TransportState.WAITING)
    assert sent(rig.all, StockAsked, to="S3") == [StockAsked(TASK, 1, "shaft", 40)]
    rig.carried()
    announced = published(rig.all, TaskAnnounced)[0]
    assert (announced.coordinator, announced.work.sources, announced.work.destination) == (  # type: ignore[union-attr]
        "S1",
        ("S3",),
        "S1",
    )
    assert rig.asks() == TransportAnswered("T-1", TransportState.ASSIGNED)
    rig.beats_in(Phase.CARRYING)
    assert rig.asks() == TransportAnswered("T-1", TransportState.ON_BOARD)
    effects = rig.put_down()
    assert instructed(effects, OpenDock) == [OpenDock(vehicle="ATV1", item="shaft", quantity=40)]
    assert sent(effects, HandoverAccepted, to="ATV1") == [HandoverAccepted(TASK, 1)]
    assert rig.states[-3:] == [TransportState.ASSIGNED, TransportState.ON_BOARD, TransportState.DELIVERED]
    assert rig.asks() == TransportAnswered("T-1", TransportState.DELIVERED)


def test_what_is_set_aside_is_announced_though_no_way_leads_there_at_the_moment() -> None:
    rig = started()
    rig.asks()
    dock = PLANT.node_of("S1")
    rig.on_message("gateway", closures(1, closure(node=dock)))
    rig.reserved()
    assert [each.task for each in published(rig.all, TaskAnnounced)][:1] == [TASK]


def test_its_heartbeat_names_its_tasks() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.run(rig.now_s + 6.0)
    assert [brief.task for brief in rig.heartbeats(StationHeartbeat)[-1].tasks] == [TASK]


def test_what_has_ended_is_not_done_again_nor_by_the_next_life() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.put_down()
    for life in (rig, restarted(rig)):
        asked = len(sent(life.all, StockAsked))
        assert life.asks() == TransportAnswered("T-1", TransportState.DELIVERED)
        assert len(sent(life.all, StockAsked)) == asked


def test_the_next_life_goes_on_with_the_same_carrier() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    after = restarted(rig)
    after.beats_in(Phase.CARRYING)
    assert after.asks() == TransportAnswered("T-1", TransportState.ON_BOARD)
    assert sent(after.put_down(), HandoverAccepted, to="ATV1")
    assert after.states[-1] is TransportState.DELIVERED


def test_the_next_life_leaves_the_dock_open_for_who_is_unloading_and_shuts_it_for_who_is_not_known() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.beats_in(Phase.CARRYING)
    rig.on_message("ATV1", Docked(TASK, 1, "S1"))
    after = restarted(rig, "ATV1", "ATV7")
    assert instructed(after.all, CloseDock) == [CloseDock(vehicle="ATV7")]


def test_a_life_without_notes_waits_for_its_carriers_before_it_begins_anything() -> None:
    after = StorageRig(100, incarnation=2)
    after.start()
    assert sent(after.on_message("gateway", ORDER), TransportAnswered) == []
    after.keeps_beating(Phase.CARRYING, until_s=11.0)
    assert after.asks() == TransportAnswered("T-1", TransportState.ON_BOARD)
    after.put_down()
    assert after.asks() == TransportAnswered("T-1", TransportState.DELIVERED)


def test_a_part_that_was_counted_is_made_up_for() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.put_down(pieces=30)
    rig.keeps_beating(Phase.HANDING_OVER, until_s=rig.now_s + 10.0)
    rig.on_message("ATV1", Handover(TASK, 1, 40))
    assert sent(rig.all, StockAsked, to="S3")[-1] == StockAsked("T-1-2", 1, "shaft", 10)
    assert TransportState.DELIVERED not in rig.states


def test_it_is_called_off_until_it_is_on_board() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    effects = rig.on_message("gateway", TransportCancelled("T-1"))
    assert sent(effects, Withdrawn, to="ATV1")
    assert sent(effects, TransportAnswered) == [TransportAnswered("T-1", TransportState.CANCELLED)]
    assert not instructed(rig.on_message("ATV1", Docked(TASK, 1, "S1")), OpenDock)
    late = started()
    late.asks()
    late.carried()
    late.beats_in(Phase.CARRYING)
    assert late.asks(TransportCancelled("T-1")) == TransportAnswered("T-1", TransportState.ON_BOARD)


def test_it_is_called_off_while_it_is_loaded_and_stays_so_when_it_is_on_board() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.beats_in(Phase.LOADING)
    effects = rig.on_message("gateway", TransportCancelled("T-1"))
    assert sent(effects, Withdrawn, to="ATV1")
    assert sent(effects, TransportAnswered) == [TransportAnswered("T-1", TransportState.CANCELLED)]
    for phase in (Phase.CARRYING, Phase.RETURNING):
        rig.beats_in(phase)
    assert rig.asks() == TransportAnswered("T-1", TransportState.CANCELLED)
    assert not instructed(rig.on_message("ATV1", Docked(TASK, 1, "S1")), OpenDock)
    assert rig.states[-1] is TransportState.CANCELLED


def test_one_that_is_called_off_before_it_was_heard_of_is_not_begun() -> None:
    rig = started()
    assert rig.asks(TransportCancelled("T-1")) == TransportAnswered("T-1", TransportState.CANCELLED)
    assert rig.asks() == TransportAnswered("T-1", TransportState.CANCELLED)
    assert sent(rig.all, StockAsked) == []


def test_nobody_is_hired_before_there_is_room() -> None:
    rig = started(stock=380)
    rig.asks()
    assert sent(rig.all, StockAsked) == []
    assert facts(rig.all, TransportProgressed)[-1].wait == "no_room"
    rig.stock["shaft"] -= 20
    rig.seq += 1
    rig.report(StockChanged(item="shaft", change=-20, seq=rig.seq, vehicle="ATV9"))
    assert [asked.task for asked in sent(rig.all, StockAsked)] == [TASK]


@pytest.mark.parametrize(
    ("changes", "refused"),
    [
        ({"item": "rotor"}, TransportRefusal.NOT_KEPT_HERE),
        ({"item": "gold"}, TransportRefusal.NOT_KEPT_HERE),
        ({"quantity": 0}, TransportRefusal.NOT_KEPT_HERE),
        ({"source": "S2"}, TransportRefusal.NOT_KEPT_THERE),
        ({"source": "S1"}, TransportRefusal.NOT_KEPT_THERE),
        ({"quantity": 41}, TransportRefusal.TOO_LARGE),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(
    changes: dict[str, Any], refused: TransportRefusal
) -> None:
    rig = started()
    answer = rig.asks(msgspec.structs.replace(ORDER, **changes))
    assert answer == TransportAnswered("T-1", TransportState.CANCELLED, refused)
    assert facts(rig.all, TransportProgressed)[-1].refused == refused


def test_it_takes_no_more_than_it_can_see_to() -> None:
    rig = started(stock=400)
    for number in range(OPEN_MAX):
        rig.asks(msgspec.structs.replace(ORDER, transport=f"T-{number}"))
    effects = rig.on_message("gateway", msgspec.structs.replace(ORDER, transport="T-more"))
    assert sent(effects, TransportAnswered) == []
    assert any(isinstance(effect, Ignore) for effect in effects)


def test_a_machine_gives_out_of_its_buffer_what_somebody_wants_taken_away() -> None:
    rig = MachineRig("M8")
    rig.stock["shaft"] = 60
    rig.start()
    asked = StockAsked(TASK, 1, "shaft", 40)
    assert sent(rig.on_message("S1", asked), StockReserved, to="S1") == [StockReserved(TASK, 1, "shaft", 40)]
    effects = rig.on_message("ATV1", Docked(TASK, 1, "M8", "shaft", 40))
    assert instructed(effects, OpenDock) == [OpenDock(vehicle="ATV1", item="shaft", quantity=40)]
    assert sent(effects, DockOpened, to="ATV1") == [DockOpened(TASK, 1, "M8")]
    assert isinstance(rig.agent, Machine)


# --- a load that was said to be there twice --------------------------------------------------------


def held() -> StorageRig:
    """Two vehicles have said that they have brought it, and the storage has counted nothing."""
    rig = started()
    rig.asks()
    rig.carried()
    boasts(rig, 1)
    rig.on_message("ATV2", bid(200.0, task=TASK, epoch=2, finish_s=rig.now_s + 300.0))
    effects: list[Effect] = []
    while not sent(effects, Award, to="ATV2") and rig.now_s < 120.0:
        effects = rig.run(rig.now_s + 0.1)
    rig.on_message("ATV2", accepted(TASK, epoch=2, number=award_number(effects, "ATV2", TASK)))
    boasts(rig, 2)
    return rig


def boasts(rig: StorageRig, epoch: int) -> None:
    atv = f"ATV{epoch}"
    rig.on_message(atv, Handover(TASK, epoch, 40))
    until_s = rig.now_s + COUNT_S + 1.0
    while rig.now_s < until_s:
        rig.run(rig.now_s + 1.0)
        rig.beats += 1
        brief = Brief(TASK, epoch, Role.PRIMARY, "S1", phase=Phase.HANDING_OVER, item="shaft", quantity=40)
        heartbeat = rhb(atv, rig.beats, rig.now_s)
        rig.on_message(atv, msgspec.structs.replace(heartbeat, task=brief))
    rig.on_message(atv, Handover(TASK, epoch, 40))


def word(rig: StorageRig, kind: MachineCommandKind) -> CommandRefusal | None:
    command = MachineCommand(command=f"C{len(rig.all)}", kind=kind, task=TASK, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("S1", command)), CommandAnswered)
    return answer.reason


def test_a_transport_to_a_storage_that_is_disputed_twice_waits_for_a_person_over_a_restart() -> None:
    rig = restarted(held())
    rig.run(rig.now_s + 1800.0)
    assert published(rig.all, TaskAnnounced) == []
    [brief] = rig.heartbeats(StationHeartbeat)[-1].tasks
    assert (brief.primary, brief.trouble) == ("", Reason.DISPUTED)
    assert published(rig.all, HelpCall)[-1].goods == TASK
    assert word(rig, MachineCommandKind.LOAD_MISSING) is None
    rig.run(rig.now_s + 10.0)
    assert {each.epoch for each in published(rig.all, TaskAnnounced)} == {3}
    assert published(rig.all, HelpCall)[-1].state is CallState.ENDED


def test_a_load_that_a_person_has_seen_in_a_storage_ends_its_transport() -> None:
    rig = held()
    assert word(rig, MachineCommandKind.RESTART) is CommandRefusal.NOT_SUPPORTED
    assert word(rig, MachineCommandKind.LOAD_THERE) is None
    assert rig.states[-1] is TransportState.DELIVERED


def test_a_transport_that_waits_for_a_person_can_be_called_off() -> None:
    rig = held()
    answer = sent(rig.on_message("gateway", TransportCancelled("T-1")), TransportAnswered)[-1]
    assert answer.state is TransportState.CANCELLED
    assert word(rig, MachineCommandKind.LOAD_THERE) is CommandRefusal.NOT_HELD


# --- since when nobody bids ---


def test_a_call_that_nobody_bids_for_says_so_once_however_often_it_is_offered() -> None:
    rig = started()
    rig.asks()
    rig.reserved()
    rig.run(900.0)
    rounds = [each for each in published(rig.all, TaskAnnounced) if each.task == TASK]
    assert len(rounds) > 5
    waits = [fact.wait for fact in facts(rig.all, TransportProgressed)]
    assert waits[-1] is TransportWait.NO_BID
    assert waits.count(TransportWait.NO_BID) == 1


# --- whose word people's bodies await ---


def test_the_next_life_tells_its_body_whose_word_of_a_load_will_not_come() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.beats_in(Phase.APPROACHING)
    after = StorageRig(rig.stock["shaft"], incarnation=2)
    after.memory, after.now_s, after.counts, after.gone = committed(rig.all), rig.now_s, False, ("ATV7",)
    assert instructed(after.start(), CloseDock) == [CloseDock("ATV7")]


def only_here() -> Plant:
    """No other storage than S1 keeps shafts."""
    storages = tuple(
        each
        if each.id == "S1"
        else msgspec.structs.replace(
            each, stocks=tuple(kept for kept in each.stocks if kept.material != "shaft")
        )
        for each in PLANT.file.storages
    )
    return Plant(msgspec.structs.replace(PLANT.file, storages=storages))


@pytest.mark.parametrize(
    ("plant", "phase", "asked"),
    [
        (PLANT, Phase.LOADING, {"S3", "S7", "S8"}),
        (PLANT, Phase.CARRYING, set()),
        (PLANT, Phase.UNLOADING, set()),
        (only_here(), Phase.LOADING, set()),
        (only_here(), Phase.CARRYING, set()),
    ],
)
def test_with_an_empty_journal_it_has_set_aside_what_is_still_to_be_fetched_and_never_asks_itself(
    plant: Plant, phase: Phase, asked: set[str]
) -> None:
    rig = started(incarnation=2, plant=plant)
    rig.beats_in(phase)
    rig.keeps_beating(phase, 6.0)
    assert [task.task for task in rig.heartbeats(StationHeartbeat)[-1].tasks] == [TASK]
    rig.keeps_beating(phase, 2 * RENEW_S)
    stations = (
        each.to for each in rig.all if isinstance(each, Send) and isinstance(each.message, StockAsked)
    )
    assert set(stations) == asked
