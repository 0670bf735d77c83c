"""Plain transports: the station of a storage has brought to it what somebody asks for, once, whatever is lost on the way."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from defaults import PLANT
from effects import award_number, committed, facts, instructed, published, sent
from rigs import MachineRig, Rig
from spoken import accepted, bid, rhb

from dray.body import OpenDock, StockChanged, StorageState
from dray.messages import (
    AtvHeartbeat,
    Brief,
    Docked,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Phase,
    Role,
    StationHeartbeat,
    StockAsked,
    StockReserved,
    TaskAnnounced,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportRefusal,
    TransportState,
    Withdrawn,
)
from dray.messages.fact import TransportProgressed
from dray.protocol.machine.machine import Machine
from dray.protocol.runtime.events import Effect, Ignore
from dray.protocol.station.station import Station
from dray.protocol.transports.called import OPEN_MAX

ORDER = TransportOrdered("T-1", "S3", "shaft", 40, 600.0)
TASK = "T-1-1"


class StorageRig(Rig):
    """The station of S1, and one vehicle."""

    def __init__(self, stock: int = 100, incarnation: int = 1) -> None:
        super().__init__(Station("S1", PLANT, incarnation=incarnation))
        self.stock = {kept.material: 0 for kept in PLANT.storages["S1"].stocks} | {"shaft": stock}
        self.seq = self.beats = 0

    def sense(self) -> StorageState:
        return StorageState(stock=dict(self.stock), seq=self.seq, opened=())

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


def restarted(rig: StorageRig) -> StorageRig:
    """Its next life, with what it has written down."""
    after = StorageRig(rig.stock["shaft"], incarnation=2)
    after.seq, after.memory, after.now_s = rig.seq, committed(rig.all), rig.now_s
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
