"""A transport job with nobody around it, for tests."""

from __future__ import annotations

from typing import Any

from defaults import PLANT
from effects import facts, instructed, sent
from spoken import transport
from vehicle_states import standing

from dray.body import Drive, Drop, Pick, WayDone
from dray.memory import Contract
from dray.messages import (
    Docked,
    DockHeld,
    DockOpened,
    Message,
    Phase,
    Superseded,
)
from dray.messages.fact import PhaseEntered
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.job.job_state import JobState
from dray.protocol.vehicle.job.transport_job import TransportJob

ROUTES = PLANT.routes("light")

GOODS: dict[str, Any] = {
    "item": "pump-p3",
    "quantity": 24,
    "sources": ("M8",),
    "destination": "DELIVERY",
    "goal": "G8",
}


class Trip:
    """A job, the vehicle under it and the time."""

    def __init__(self, node: str = "p3", source: str = "S3", **changes: Any) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.now_s = 0.0
        self.driver = Driver(PLANT, "light", self.life)
        self.driver.sense(standing(PLANT, node))
        self.job = TransportJob(
            Contract(
                task="M8-1",
                epoch=1,
                work=transport(**changes),
                coordinator="M8",
                source=source,
                promised_s=100.0,
                deadline_s=300.0,
            ),
            plant=PLANT,
            vehicle_type="light",
            driver=self.driver,
            life=self.life,
        )
        self.load = ""
        self.takes_back = True
        """A storage to which the load is brought back opens its dock at once."""
        self.job.set_off(0.0)

    @property
    def phases(self) -> list[Phase]:
        return [fact.phase for fact in facts(self.life.effects, PhaseEntered)]

    def arrives(self, *, opens: bool = True) -> None:
        """The newest way is driven; a storage lets the vehicle load at once, unless the test answers for it."""
        way = instructed(self.life.effects, Drive)[-1]
        self.driver.on_done(WayDone(order=way.order, node=way.nodes[-1]), 0.0)
        self.job.arrived(self.now_s)
        source = self.job.source
        if opens and self.job.phase is Phase.LOADING and source in PLANT.storages:
            self.opened(source)
        self._let_back()

    def _let_back(self) -> None:
        if self.takes_back and self.job.state is JobState.AT_REFUGE:
            self.opened([each for each in sent(self.life.effects, Docked) if each.returns][-1].station)

    def hears(self, message: Message) -> None:
        self.job.on_answer(message, self.now_s)

    def opened(self, station: str = "M8") -> None:
        self.hears(DockOpened(task="M8-1", epoch=1, station=station))

    def held(self, station: str = "M8") -> None:
        self.hears(DockHeld(task="M8-1", epoch=1, station=station, reason="the buffer is full"))

    def superseded(self) -> None:
        self.hears(Superseded(task="M8-1", epoch=2))

    def done(self, kind: type[Pick | Drop]) -> None:
        self.load = self.job.work.item if kind is Pick else ""
        self.job.action_done(instructed(self.life.effects, kind)[-1].order, self.now_s)
        self._let_back()

    def fails(self, kind: type[Pick | Drop]) -> None:
        self.job.action_failed(instructed(self.life.effects, kind)[-1].order, "no contact", self.now_s)

    def waits(self) -> None:
        """Until the alarm."""
        assert self.life.timers.next_s < NEVER_S
        self.now_s = self.life.timers.next_s
        for _ in self.life.timers.due(self.now_s):
            self.job.wake(self.load, self.now_s)
        self._let_back()

    def to_loading(self) -> Trip:
        self.arrives()
        return self

    def to_carrying(self) -> Trip:
        self.to_loading().done(Pick)
        return self

    def to_unloading(self) -> Trip:
        self.to_carrying().arrives()
        return self

    def to_dropping(self) -> Trip:
        self.to_unloading().opened()
        return self

    def to_handing_over(self) -> Trip:
        self.to_dropping().done(Drop)
        return self
