"""Plain transports: the station of a storage has brought to it what somebody asks for, once, whatever is lost on the way."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from closed import closure, closures
from defaults import PLANT
from effects import award_number, committed, facts, instructed, published, sent
from rigs import MachineRig, Rig
from seals import granted, trusts_seals
from spoken import accepted, bid, rhb

from dray.body import CloseDock, OpenDock, StockChanged, StorageState
from dray.memory import TransportMemory
from dray.messages import (
    THING,
    AtvHeartbeat,
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
    Message,
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
    TransportWait,
    Withdrawn,
)
from dray.messages.fact import TransportProgressed
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import Effect, Ignore
from dray.protocol.station.station import Station
from dray.protocol.takeover.left_aboard import WRITTEN_OFF_AFTER_S
from dray.protocol.transports.called import LOOK_AGAIN_S, OPEN_MAX
from dray.protocol.transports.receiving import COUNT_S

ORDER = TransportOrdered("T-1", "S3", "shaft", 40, 600.0)
TASK = "T-1-1"


class StorageRig(Rig):
    """The station of S1, and one vehicle."""

    def __init__(self, stock: int = 100, incarnation: int = 1) -> None:
        super().__init__(Station("S1", PLANT, incarnation=incarnation, trusts=trusts_seals))
        self.stock = {kept.material: 0 for kept in PLANT.storages["S1"].stocks} | {"shaft": stock}
        self.seq = self.beats = 0
        self.opened: tuple[str, ...] = ()
        self.gone: tuple[str, ...] = ()
        self.counts = True

    def sense(self) -> StorageState:
        return StorageState(
            stock=dict(self.stock), seq=self.seq, opened=self.opened, counts=self.counts, gone=self.gone
        )

    def asks(self, order: Message = ORDER) -> TransportAnswered:
        """Somebody asks, and is answered."""
        return sent(self.on_message("gateway", order), TransportAnswered, to="gateway")[-1]

    def reserved(self, task: str = TASK) -> list[Effect]:
        return self.on_message("S3", StockReserved(task, 1, "shaft", 40))

    def beats_in(self, phase: Phase, task: str = TASK) -> list[Effect]:
        self.beats += 1
        brief = Brief(task, 1, Role.PRIMARY, "S1", phase=phase, item="shaft", quantity=40)
        heartbeat: AtvHeartbeat = rhb("ATV1", self.beats, self.now_s)
        return self.on_message("ATV1", msgspec.structs.replace(heartbeat, task=brief))

    def keeps_beating(self, phase: Phase, until_s: float) -> None:
        while self.now_s < until_s:
            self.beats_in(phase)
            self.run(self.now_s + 1.0)

    def carried(self, task: str = TASK) -> None:
        """ATV1 has taken it."""
        self.reserved(task)
        self.on_message("ATV1", bid(200.0, task=task, finish_s=self.now_s + 300.0))
        self.run(self.now_s + 1.2)
        number = award_number(self.all, "ATV1", task)
        self.on_message("ATV1", accepted(task, number=number))

    def put_down(self, task: str = TASK, pieces: int = 40) -> list[Effect]:
        """The vehicle unloads, and hands over."""
        effects = self.on_message("ATV1", Docked(task, 1, "S1"))
        self.stock["shaft"] += pieces
        self.seq += 1
        effects += self.report(StockChanged(item="shaft", change=pieces, seq=self.seq, vehicle="ATV1"))
        return effects + self.on_message("ATV1", Handover(task, 1, 40))

    @property
    def states(self) -> list[TransportState]:
        return [fact.state for fact in facts(self.all, TransportProgressed)]


def started(**options: Any) -> StorageRig:
    rig = StorageRig(**options)
    rig.start()
    return rig


def restarted(rig: StorageRig, *opened: str) -> StorageRig:
    """Its next life, with what it has written down."""
    after = StorageRig(rig.stock["shaft"], incarnation=2)
    after.seq, after.memory, after.now_s = rig.seq, committed(rig.all), rig.now_s
    after.opened = opened
    after.start()
    return after


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


def test_only_the_vehicle_that_was_named_may_carry_it() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, vehicle="ATV7"))
    rig.carried()
    assert TransportState.ASSIGNED not in rig.states


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


WISH = msgspec.structs.replace(ORDER, vehicle="ATV1", vehicle_until_s=20.0)


def wanted(rig: StorageRig) -> dict[str, str]:
    """By the name of each task that was announced, the only vehicle that may carry it."""
    announced = published(rig.all, TaskAnnounced)
    return {each.task: each.work.vehicle for each in announced if isinstance(each.work, Transport)}


def test_a_wish_is_held_until_its_time_and_then_any_vehicle_may_carry() -> None:
    rig = started()
    rig.asks(WISH)
    rig.reserved()
    rig.run(19.0)
    assert wanted(rig) == {TASK: "ATV1"}
    effects = rig.on_message("ATV7", bid(100.0, task=TASK, finish_s=200.0))
    assert any(isinstance(effect, Ignore) for effect in effects)
    rig.run(21.0)
    assert [ask.task for ask in sent(rig.all, StockAsked, to="S3")][-1] == "T-1-2"
    rig.reserved("T-1-2")
    rig.run(23.0)
    assert wanted(rig) == {TASK: "ATV1", "T-1-2": ""}
    assert rig.asks(WISH) == TransportAnswered("T-1", TransportState.WAITING)


def test_a_wish_that_is_met_in_time_stays_with_its_vehicle() -> None:
    rig = started()
    rig.asks(WISH)
    rig.carried()
    rig.keeps_beating(Phase.APPROACHING, 40.0)
    assert wanted(rig) == {TASK: "ATV1"}
    rig.beats_in(Phase.CARRYING)
    rig.put_down()
    assert rig.states[-1] is TransportState.DELIVERED
    assert wanted(rig) == {TASK: "ATV1"}


def test_whoever_gives_back_what_it_was_wished_for_is_waited_for_no_longer_than_that() -> None:
    rig = started()
    rig.asks(WISH)
    rig.carried()
    rig.keeps_beating(Phase.APPROACHING, 30.0)
    rig.on_message("ATV1", Resigned(TASK, 1, Role.PRIMARY, Reason.CLOSED))
    rig.run(30.0 + 2 * LOOK_AGAIN_S)
    rig.reserved("T-1-2")
    rig.run(rig.now_s + 2.0)
    assert wanted(rig)["T-1-2"] == ""


def test_the_next_life_holds_a_wish_as_long() -> None:
    rig = started()
    rig.asks(WISH)
    rig.reserved()
    rig.run(10.0)
    after = restarted(rig)
    after.run(19.0)
    assert {*wanted(after).values()} <= {"ATV1"}
    after.run(21.0)
    [named] = {ask.task for ask in sent(after.all, StockAsked, to="S3")} - {TASK}
    after.reserved(named)
    after.run(23.0)
    assert wanted(after)[named] == ""


def test_an_order_that_names_one_vehicle_for_always_waits_for_it() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, vehicle="ATV7"))
    rig.reserved()
    rig.run(3600.0)
    assert wanted(rig) == {TASK: "ATV7"}


def test_what_somebody_wants_of_its_vehicle_is_announced_in_every_life() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, ability="pallet"))
    rig.reserved()
    works = [each.work for each in published(rig.all, TaskAnnounced)]
    assert {work.needed for work in works if isinstance(work, Transport)} == {("tote", "pallet")}
    after = restarted(rig)
    after.run(120.0)
    after.reserved()
    again = [each.work for each in published(after.all, TaskAnnounced)]
    assert {work.needed for work in again if isinstance(work, Transport)} == {("tote", "pallet")}
    [note] = [each for each in committed(rig.all).values() if isinstance(each, TransportMemory)]
    assert note.ability == "pallet"


@pytest.mark.parametrize("wish", [{"vehicle": "ATV7"}, {"ability": "pallet"}])
def test_what_was_wanted_of_its_vehicle_holds_after_the_notes_were_lost(wish: dict[str, str]) -> None:
    """A carrier does not tell what was wanted of it: when it fails as well, only the order that comes again begins anything."""
    rig = started(incarnation=2)
    rig.keeps_beating(Phase.APPROACHING, until_s=11.0)
    order = msgspec.structs.replace(ORDER, **wish)
    assert rig.asks(order) == TransportAnswered("T-1", TransportState.ASSIGNED)
    rig.run(30.0)
    assert published(rig.all, TaskAnnounced) == []
    again = sent(rig.all, StockAsked, to="S3")[-1].task
    rig.reserved(again)
    works = [each.work for each in published(rig.all, TaskAnnounced) if each.task == again]
    named = [(work.vehicle, work.also) for work in works if isinstance(work, Transport)]
    assert named == [(order.vehicle, order.ability)]


def test_when_the_only_vehicle_dies_with_the_load_it_is_asked_again_and_nobody_else() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, vehicle="ATV1"))
    rig.carried()
    rig.beats_in(Phase.CARRYING)
    rig.run(120.0)
    again = [each for each in published(rig.all, TaskAnnounced) if each.epoch > 1]
    assert again
    assert {each.role for each in published(rig.all, TaskAnnounced)} == {Role.PRIMARY}
    assert set(wanted(rig).values()) == {"ATV1"}


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


# --- things without master data ---

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


def beats_without_contract(rig: StorageRig, first: int, load: str) -> None:
    """ATV1 tells of no task, for a minute."""
    for seq in range(first, first + 60):
        heartbeat = msgspec.structs.replace(
            rhb("ATV1", seq, rig.now_s), load=load, load_quantity=1 if load else 0
        )
        rig.on_message("ATV1", heartbeat)
        rig.run(rig.now_s + 1.0)


def test_a_vehicle_that_has_forgotten_its_transport_and_has_the_thing_on_board_waits_for_a_person() -> None:
    rig = with_thing_aboard()
    beats_without_contract(rig, 2, THING)
    assert {each.epoch for each in published(rig.all, TaskAnnounced)} == {1}
    assert (call := published(rig.all, HelpCall)[-1]).goods == THING_TASK
    assert call.state is not CallState.ENDED
    # A person takes it off first, and says so then.
    beats_without_contract(rig, 100, "")
    assert {each.epoch for each in published(rig.all, TaskAnnounced)} == {1}
    assert thing_word(rig, MachineCommandKind.FETCH_GOODS, "b2") is None
    rig.run(rig.now_s + 200.0)
    work = published(rig.all, TaskAnnounced)[-1].work
    assert isinstance(work, Transport)
    assert work.sources == ("b2",)


# --- whose word people's bodies await ---


def test_the_next_life_tells_its_body_whose_word_of_a_load_will_not_come() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.beats_in(Phase.APPROACHING)
    after = StorageRig(rig.stock["shaft"], incarnation=2)
    after.memory, after.now_s, after.counts, after.gone = committed(rig.all), rig.now_s, False, ("ATV7",)
    assert instructed(after.start(), CloseDock) == [CloseDock("ATV7")]


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
