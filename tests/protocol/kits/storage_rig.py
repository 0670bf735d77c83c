"""The station of a storage which is asked for plain transports, and one vehicle."""

from __future__ import annotations

from typing import Any

import msgspec
from defaults import PLANT
from effects import award_number, committed, facts, sent
from rigs import Rig
from seals import trusts_seals
from spoken import accepted, bid, rhb

from dray.body import StockChanged, StorageState
from dray.messages import (
    AtvHeartbeat,
    Brief,
    Docked,
    Handover,
    Message,
    Phase,
    Role,
    StockReserved,
    TransportAnswered,
    TransportOrdered,
    TransportState,
)
from dray.messages.fact import TransportProgressed
from dray.plant import Plant
from dray.protocol.runtime.events import Effect
from dray.protocol.station.station import Station

ORDER = TransportOrdered("T-1", "S3", "shaft", 40, 600.0)
TASK = "T-1-1"


class StorageRig(Rig):
    """The station of S1, and one vehicle."""

    def __init__(self, stock: int = 100, incarnation: int = 1, plant: Plant = PLANT) -> None:
        super().__init__(Station("S1", plant, incarnation=incarnation, trusts=trusts_seals))
        self.stock = {kept.material: 0 for kept in plant.storages["S1"].stocks} | {"shaft": stock}
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
