"""Things without master data: the station of a storage has them brought, and asks people when one is on board of a vehicle that has failed."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from effects import award_number, instructed, published, sent
from seals import granted
from spoken import accepted, bid, rhb
from storage_rig import StorageRig, restarted, started

from dray.body import OpenDock, StockChanged
from dray.messages import (
    THING,
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
    Resigned,
    Role,
    StationHeartbeat,
    StockAsked,
    StockReserved,
    StrandedGoods,
    TaskAnnounced,
    Transport,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportRefusal,
    TransportState,
)
from dray.protocol.takeover.left_aboard import WRITTEN_OFF_AFTER_S

PUMP = TransportOrdered("T-9", "M8", THING, 1, 600.0, ability="tote")


def test_a_thing_is_set_aside_at_its_place_fetched_by_who_carries_such_and_counted_in_no_stock() -> None:
    rig = started(stock=100)
    assert rig.asks(PUMP) == TransportAnswered("T-9", TransportState.WAITING)
    assert sent(rig.all, StockAsked, to="M8") == [StockAsked("T-9-1", 1, THING, 1)]
    rig.on_message("M8", StockReserved("T-9-1", 1, THING, 1))
    announced = published(rig.all, TaskAnnounced)[-1].work
    assert isinstance(announced, Transport)
    assert (announced.item, announced.needed, announced.sources) == (THING, ("tote",), ("M8",))
    offered = bid(200.0, task="T-9-1", finish_s=rig.now_s + 300.0)
    rig.on_message("ATV1", msgspec.structs.replace(offered, source="M8"))
    rig.run(rig.now_s + 1.2)
    taken = accepted("T-9-1", number=award_number(rig.all, "ATV1", "T-9-1"))
    rig.on_message("ATV1", taken)
    effects = rig.on_message("ATV1", Docked("T-9-1", 1, "S1"))
    assert instructed(effects, OpenDock) == [OpenDock(vehicle="ATV1", item=THING, quantity=1)]
    rig.seq += 1
    rig.report(StockChanged(item=THING, change=1, seq=rig.seq, vehicle="ATV1"))
    effects = rig.on_message("ATV1", Handover("T-9-1", 1, 1))
    assert sent(effects, HandoverAccepted, to="ATV1") == [HandoverAccepted("T-9-1", 1)]
    assert rig.states[-1] is TransportState.DELIVERED
    rig.run(rig.now_s + 10.0)
    told = published(rig.all, StationHeartbeat)[-1]
    assert THING not in [stock.item for stock in told.stocks]


@pytest.mark.parametrize(
    ("fields", "refused"),
    [
        ({"quantity": 2}, TransportRefusal.TOO_LARGE),
        ({"source": "S1"}, TransportRefusal.NOT_KEPT_THERE),
        ({"source": "nowhere"}, TransportRefusal.NOT_KEPT_THERE),
        ({"ability": ""}, TransportRefusal.NOT_KEPT_HERE),
    ],
)
def test_a_thing_that_cannot_be_fetched_is_refused(fields: dict[str, Any], refused: TransportRefusal) -> None:
    answer = started().asks(msgspec.structs.replace(PUMP, **fields))
    assert (answer.state, answer.refused) == (TransportState.CANCELLED, refused)


def test_a_storage_hands_a_thing_out_and_counts_nothing() -> None:
    rig = started(stock=7)
    [reserved] = sent(rig.on_message("M8", StockAsked("T-7-1", 1, THING, 1)), StockReserved, to="M8")
    assert reserved == StockReserved("T-7-1", 1, THING, 1)
    effects = rig.on_message("ATV1", Docked("T-7-1", 1, "S1", item=THING, quantity=1))
    assert instructed(effects, OpenDock) == [OpenDock(vehicle="ATV1", item=THING, quantity=1)]
    rig.seq += 1
    rig.report(StockChanged(item=THING, change=-1, seq=rig.seq, vehicle="ATV1"))
    rig.run(rig.now_s + 10.0)
    told = {stock.item: stock.level for stock in published(rig.all, StationHeartbeat)[-1].stocks}
    assert (told["shaft"], THING in told) == (7, False)
    # The count is believed again: what it has told since is known.
    rig.stock["shaft"] = 5
    rig.run(rig.now_s + 10.0)
    told = {stock.item: stock.level for stock in published(rig.all, StationHeartbeat)[-1].stocks}
    assert told["shaft"] == 5


# --- a thing on board of a vehicle that has failed ---

THING_TASK = "T-9-1"


def thing_beats(
    rig: StorageRig, atv: str, seq: int, *, epoch: int = 1, phase: Phase = Phase.CARRYING
) -> None:
    brief = Brief(THING_TASK, epoch, Role.PRIMARY, "S1", phase=phase, item=THING, quantity=1)
    rig.on_message(atv, msgspec.structs.replace(rhb(atv, seq, rig.now_s), task=brief))


def with_thing_aboard(phase: Phase = Phase.CARRYING, order: TransportOrdered = PUMP) -> StorageRig:
    """ATV1 has a thing for S1 on board, which it has fetched at M8; or loads it."""
    rig = started()
    rig.asks(order)
    rig.on_message("M8", StockReserved(THING_TASK, 1, THING, 1))
    offered = bid(200.0, task=THING_TASK, finish_s=rig.now_s + 300.0)
    rig.on_message("ATV1", msgspec.structs.replace(offered, source="M8"))
    rig.run(rig.now_s + 1.2)
    rig.on_message("ATV1", accepted(THING_TASK, number=award_number(rig.all, "ATV1", THING_TASK)))
    thing_beats(rig, "ATV1", 1, phase=phase)
    return rig


def silent_with_thing(order: TransportOrdered = PUMP) -> StorageRig:
    rig = with_thing_aboard(order=order)
    rig.run(rig.now_s + 100.0)
    return rig


def thing_word(rig: StorageRig, kind: MachineCommandKind, node: str = "") -> CommandRefusal | None:
    command = MachineCommand(
        command=f"C{len(rig.all)}", kind=kind, task=THING_TASK, node=node, issued_by="Maria"
    )
    [answer] = sent(rig.on_message("gateway", granted("S1", command)), CommandAnswered)
    return answer.reason


def test_a_thing_whose_vehicle_has_failed_is_not_looked_for_where_it_was_and_people_are_told_where_it_is() -> (
    None
):
    rig = silent_with_thing()
    assert {each.epoch for each in published(rig.all, TaskAnnounced)} == {1}
    [brief] = rig.heartbeats(StationHeartbeat)[-1].tasks
    assert isinstance(brief.stranded, StrandedGoods)
    assert (brief.primary, brief.stranded.atv, brief.stranded.node) == ("ATV1", "ATV1", "a1")
    call = published(rig.all, HelpCall)[-1]
    assert (call.goods, call.caller) == (THING_TASK, "S1")
    answer = sent(rig.on_message("gateway", TransportCancelled("T-9")), TransportAnswered)[-1]
    assert answer.state is TransportState.ON_BOARD


def test_a_thing_that_is_called_off_while_it_is_loaded_is_waited_for_by_nobody_when_its_vehicle_fails() -> (
    None
):
    """Nobody wants it any more: its vehicle brings it back, and whoever sees to the vehicle finds it on board."""
    rig = with_thing_aboard(Phase.LOADING)
    answer = sent(rig.on_message("gateway", TransportCancelled("T-9")), TransportAnswered)[-1]
    assert answer.state is TransportState.CANCELLED
    thing_beats(rig, "ATV1", 2)
    rig.run(rig.now_s + 2.0 * WRITTEN_OFF_AFTER_S)
    assert rig.heartbeats(StationHeartbeat)[-1].tasks == ()
    assert published(rig.all, HelpCall) == []
    assert rig.states[-1] is TransportState.CANCELLED


@pytest.mark.parametrize("restart", [False, True], ids=["in one life", "in the next life"])
@pytest.mark.parametrize("until_s", [None, 20.0, 250.0], ids=["for always", "ended", "not ended"])
@pytest.mark.parametrize("vehicle", ["", "ATV1"])
def test_a_thing_is_fetched_where_a_person_hands_it_over(
    vehicle: str, until_s: float | None, restart: bool
) -> None:
    """By any vehicle: the only one that was to carry it has failed."""
    rig = silent_with_thing(msgspec.structs.replace(PUMP, vehicle=vehicle, vehicle_until_s=until_s))
    if restart:
        rig = restarted(rig)
    asked = len(sent(rig.all, StockAsked))
    assert thing_word(rig, MachineCommandKind.FETCH_GOODS, "b2") is None
    rig.run(rig.now_s + 200.0)
    work = published(rig.all, TaskAnnounced)[-1].work
    assert isinstance(work, Transport)
    assert (work.sources, work.handed_at, work.item) == (("b2",), "b2", THING)
    assert len(sent(rig.all, StockAsked)) == asked
    offered = bid(200.0, task=THING_TASK, epoch=2, finish_s=rig.now_s + 300.0)
    effects = rig.on_message("ATV2", msgspec.structs.replace(offered, source="b2"))
    while not sent(effects, Award, to="ATV2"):
        assert rig.now_s < 1000.0, "nobody else may fetch it"
        effects += rig.run(rig.now_s + 0.5)
    rig.on_message("ATV2", accepted(THING_TASK, epoch=2, number=award_number(effects, "ATV2", THING_TASK)))
    opened = sent(rig.on_message("ATV2", Docked(THING_TASK, 2, "b2")), DockOpened, to="ATV2")
    assert [each.station for each in opened] == ["b2"]
    thing_beats(rig, "ATV2", 1, epoch=2)
    rig.on_message("ATV2", Docked(THING_TASK, 2, "S1"))
    rig.seq += 1
    rig.report(StockChanged(item=THING, change=1, seq=rig.seq, vehicle="ATV2"))
    rig.on_message("ATV2", Handover(THING_TASK, 2, 1))
    assert rig.states[-1] is TransportState.DELIVERED


def test_a_thing_is_looked_for_where_it_was_when_nobody_has_said_anything_or_it_was_written_off() -> None:
    for kind in (None, MachineCommandKind.WRITE_OFF):
        rig = silent_with_thing()
        if kind is not None:
            assert thing_word(rig, kind) is None
        rig.run(rig.now_s + (WRITTEN_OFF_AFTER_S if kind is None else 1.0))
        assert [each.task for each in sent(rig.all, StockAsked, to="M8")][-1] == "T-9-2"


def test_a_vehicle_that_is_heard_again_goes_on_with_its_thing() -> None:
    rig = with_thing_aboard()
    rig.run(rig.now_s + 10.0)
    [brief] = rig.heartbeats(StationHeartbeat)[-1].tasks
    assert isinstance(brief.stranded, StrandedGoods)
    for seq in range(2, 8):
        thing_beats(rig, "ATV1", seq)
        rig.run(rig.now_s + 1.0)
    [brief] = rig.heartbeats(StationHeartbeat)[-1].tasks
    assert (brief.stranded, brief.primary, brief.epoch) == (msgspec.UNSET, "ATV1", 1)


def test_a_vehicle_that_lives_and_has_the_thing_no_more_lets_it_be_looked_for_where_it_was() -> None:
    rig = with_thing_aboard()
    rig.on_message("ATV1", Resigned(THING_TASK, 1, Role.PRIMARY, Reason.LOAD_GONE))
    rig.run(rig.now_s + 30.0)
    work = published(rig.all, TaskAnnounced)[-1].work
    assert isinstance(work, Transport)
    assert work.sources == ("M8",)


def test_a_vehicle_that_comes_back_without_its_thing_ends_the_wait_for_a_person() -> None:
    rig = silent_with_thing()
    for seq in range(2, 40):
        rig.on_message("ATV1", rhb("ATV1", seq, rig.now_s))
        rig.run(rig.now_s + 1.0)
    [brief] = rig.heartbeats(StationHeartbeat)[-1].tasks
    assert (brief.stranded, brief.primary, brief.epoch) == (msgspec.UNSET, "", 2)
    rig.run(rig.now_s + 2.0 * WRITTEN_OFF_AFTER_S)
    assert {each.task for each in published(rig.all, TaskAnnounced)} == {THING_TASK}


def test_that_a_thing_is_on_board_is_known_to_the_next_life() -> None:
    rig = restarted(with_thing_aboard())
    rig.run(rig.now_s + 100.0)
    [brief] = rig.heartbeats(StationHeartbeat)[-1].tasks
    assert isinstance(brief.stranded, StrandedGoods)
    assert published(rig.all, TaskAnnounced) == []


def test_that_a_vehicle_goes_on_with_its_thing_is_known_to_the_next_life() -> None:
    rig = with_thing_aboard()
    rig.run(rig.now_s + 10.0)
    for seq in range(2, 8):
        thing_beats(rig, "ATV1", seq)
        rig.run(rig.now_s + 1.0)
    after = restarted(rig)
    after.run(after.now_s + 1.0)
    [brief] = after.heartbeats(StationHeartbeat)[-1].tasks
    assert (brief.stranded, brief.primary) == (msgspec.UNSET, "ATV1")


def beats_without_contract(rig: StorageRig, first: int, load: str, node: str = "a1") -> None:
    """ATV1 tells of no task, for a minute."""
    for seq in range(first, first + 60):
        heartbeat = msgspec.structs.replace(
            rhb("ATV1", seq, rig.now_s), load=load, load_quantity=1 if load else 0, node=node
        )
        rig.on_message("ATV1", heartbeat)
        rig.run(rig.now_s + 1.0)


@pytest.mark.parametrize("restart", [False, True], ids=["in one life", "in the next life"])
def test_a_vehicle_that_has_forgotten_its_transport_and_has_the_thing_on_board_waits_for_a_person(
    restart: bool,
) -> None:
    rig = with_thing_aboard()
    beats_without_contract(rig, 2, THING)
    assert {each.epoch for each in published(rig.all, TaskAnnounced)} == {1}
    assert (call := published(rig.all, HelpCall)[-1]).goods == THING_TASK
    assert call.state is not CallState.ENDED
    # It brings the thing to a storage by itself, and people are sent there.
    beats_without_contract(rig, 100, THING, "b3")
    [brief] = rig.heartbeats(StationHeartbeat)[-1].tasks
    assert isinstance(brief.stranded, StrandedGoods)
    assert brief.stranded.node == "b3"
    # A person takes it off first, and says so then.
    if restart:
        rig = restarted(rig)
    beats_without_contract(rig, 200, "")
    assert {each.epoch for each in published(rig.all, TaskAnnounced)} <= {1}
    assert thing_word(rig, MachineCommandKind.FETCH_GOODS, "b2") is None
    rig.run(rig.now_s + 200.0)
    work = published(rig.all, TaskAnnounced)[-1].work
    assert isinstance(work, Transport)
    assert work.sources == ("b2",)
