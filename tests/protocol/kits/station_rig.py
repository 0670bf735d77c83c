"""The station of S1 alone: the test stands for its storage, the coordinators and the vehicles."""

from __future__ import annotations

from defaults import PLANT
from effects import instructed
from rigs import Rig

from dray.body import OpenDock, StockChanged, StorageState
from dray.messages import Docked, StationHeartbeat, StockAsked, StockLevel
from dray.protocol.runtime.events import Effect
from dray.protocol.station.station import Station

SPEC = PLANT.storages["S1"]
ITEM = "shaft"


class StationRig(Rig):
    """The station, and its storage of shafts."""

    def __init__(self, stock: int = 100, incarnation: int = 1) -> None:
        super().__init__(Station("S1", PLANT, incarnation=incarnation))
        self.stock = {kept.material: 0 for kept in SPEC.stocks} | {ITEM: stock}
        self.seq = 0
        self.opened: dict[str, None] = {}
        self.answers, self.counts = False, True

    def sense(self) -> StorageState:
        return StorageState(
            stock=dict(self.stock),
            seq=self.seq,
            opened=tuple(self.opened),
            answers=self.answers,
            counts=self.counts,
        )

    def asks(self, task: str, quantity: int = 40, *, machine: str = "M8", epoch: int = 1) -> list[Effect]:
        return self.on_message(machine, StockAsked(task=task, epoch=epoch, item=ITEM, quantity=quantity))

    def docks(self, atv: str, task: str, *, epoch: int = 1, quantity: int = 40) -> list[Effect]:
        effects = self.on_message(
            atv, Docked(task=task, epoch=epoch, station="S1", item=ITEM, quantity=quantity)
        )
        self.opened |= {opening.vehicle: None for opening in instructed(effects, OpenDock)}
        return effects

    def changes(self, pieces: int, vehicle: str = "") -> list[Effect]:
        """The storage is refilled, or a vehicle has taken something out."""
        self.stock[ITEM] += pieces
        self.seq += 1
        self.opened.pop(vehicle, None)
        return self.report(StockChanged(item=ITEM, change=pieces, seq=self.seq, vehicle=vehicle))

    @property
    def level(self) -> StockLevel:
        """Of the shafts, as the newest heartbeat tells."""
        self.run(self.now_s)
        newest = self.heartbeats(StationHeartbeat)[-1]
        return next(level for level in newest.stocks if level.item == ITEM)


def started(stock: int = 100) -> StationRig:
    rig = StationRig(stock)
    rig.start()
    return rig
