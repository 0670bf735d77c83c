"""A committed transport, as its carrier lives it: approach, load, carry, unload, hand over.

    APPROACHING -> LOADING -> CARRYING -> UNLOADING -> HANDING_OVER -> ended
         |            |           |            |
         +-- ended    +-----------+------------+--> RETURNING -> ended      (superseded, withdrawn)

At the coordinator's own dock, and before anything is put down anywhere, the carrier asks first
(`Docked`); the coordinator opens the dock to the present epoch alone. Questions and the handover are
repeated until they are answered, so a lost message costs seconds and no load.
"""

from __future__ import annotations

from dray.body import Drop, Pick
from dray.messages import (
    Brief,
    Docked,
    DockHeld,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Phase,
    Role,
    Superseded,
    Transport,
    Withdrawn,
)
from dray.messages.fact import PhaseEntered
from dray.plant import Plant
from dray.protocol.driving import Driver
from dray.protocol.events import Effect, Ignore, Record, Send
from dray.protocol.timers import Timers

ASK = "ask"
"""The alarm for whatever the carriage waits for: an answer, or another try."""

ASK_AGAIN_S = 3.0
"""A question is repeated after many times the latency of a good link."""

HELD_ASK_AGAIN_S = 5.0
"""A dock that is held has no room yet: asking often would not make any."""

RETRY_S = 5.0
"""After a failed manoeuvre."""


class Carriage:
    """One transport of one vehicle.

    Args:
        atv: the vehicle.
        task, epoch, work, coordinator, source: the contract.
        promised_s: when the vehicle promised to be done.
        plant, vehicle_type: for ways and handling times.
        driver: the vehicle's place on the lanes.
        timers: the vehicle's alarms; this class uses `ASK`.
        out: where effects go.
    """

    def __init__(
        self,
        atv: str,
        *,
        task: str,
        epoch: int,
        work: Transport,
        coordinator: str,
        source: str,
        promised_s: float,
        plant: Plant,
        vehicle_type: str,
        driver: Driver,
        timers: Timers,
        out: list[Effect],
    ) -> None:
        self._atv = atv
        self.task = task
        self.epoch = epoch
        self.work = work
        self.coordinator = coordinator
        self.source = source
        self.promised_s = promised_s
        self.due_s = promised_s
        """When it now expects to hand over."""
        self.phase = Phase.APPROACHING
        self.ended = ""
        """Why it is over: `handed_over`, `superseded`, `withdrawn`, or a reason; empty while it lasts."""
        self._plant = plant
        self._type = plant.vehicle_types[vehicle_type]
        self._routes = plant.routes(vehicle_type)
        self._driver = driver
        self._timers = timers
        self._out = out
        self._action = 0
        """The order number of the running pick or drop; 0 for none."""
        self._loaded = False
        self._cancelled = ""
        """Why it is to end as soon as the running manoeuvre is over."""
        self._station = source

    def brief(self) -> Brief:
        """What the vehicle tells about it in its heartbeat."""
        return Brief(
            task=self.task,
            epoch=self.epoch,
            role=Role.PRIMARY,
            coordinator=self.coordinator,
            phase=self.phase,
            item=self.work.item,
            quantity=self.work.quantity,
            due_s=self.due_s,
        )

    # --- what happens ---

    def begin(self, now_s: float) -> None:
        """Set off for the source."""
        self._enter(Phase.APPROACHING, self.source)
        self._drive(self.source, now_s)

    def arrived(self, now_s: float) -> None:
        """The vehicle stands where it was sent."""
        if self.phase is Phase.APPROACHING:
            self._enter(Phase.LOADING, self.source)
            self._ask_to_load(now_s)
        elif self.phase is Phase.CARRYING:
            self._enter(Phase.UNLOADING, self.work.destination)
            self._ask_for_dock(now_s)
        elif self.phase is Phase.RETURNING:
            self._drop()

    def way_refused(self, now_s: float) -> None:
        """The vehicle could not take the way: try again from where it is then."""
        self._timers.set(ASK, now_s + RETRY_S)

    def action_done(self, order: int, now_s: float) -> None:
        """A pick or drop has ended well."""
        if order != self._action:
            return
        self._action = 0
        if self.phase is Phase.LOADING:
            self._loaded = True
            if self._cancelled:
                self._return(now_s)
            else:
                self._enter(Phase.CARRYING, self.work.destination)
                self._drive(self.work.destination, now_s)
        elif self.phase is Phase.UNLOADING:
            self._loaded = False
            if self._cancelled:
                self._end(self._cancelled)
            else:
                self._enter(Phase.HANDING_OVER, self.work.destination)
                self._say_handover(now_s)
        elif self.phase is Phase.RETURNING:
            self._loaded = False
            self._end(self._cancelled)

    def action_failed(self, order: int, now_s: float) -> None:
        """A pick or drop ended without effect."""
        if order != self._action:
            return
        self._action = 0
        if self._cancelled and self.phase is not Phase.RETURNING:
            self._give_up(now_s)
        else:
            self._timers.set(ASK, now_s + RETRY_S)

    def hear(self, message: Message, now_s: float) -> None:
        """Take an answer of the coordinator; what is late or doubled changes nothing."""
        if isinstance(message, Superseded) and not 0 < message.epoch < self.epoch:
            self.cancel("superseded", now_s)
        elif isinstance(message, Withdrawn):
            self.cancel("withdrawn", now_s)
        elif isinstance(message, HandoverAccepted) and self.phase is Phase.HANDING_OVER:
            self._end("handed_over")
        elif isinstance(message, DockHeld) and self._waits_at(message.station):
            self._timers.set(ASK, now_s + HELD_ASK_AGAIN_S)
        elif isinstance(message, DockOpened) and self._waits_at(message.station):
            self._timers.clear(ASK)
            self._transfer()
        else:
            self._out.append(Ignore("an answer that nothing waits for any more"))

    def cancel(self, reason: str, now_s: float) -> None:
        """The contract is void: end, and take the load back if there is one."""
        if self._cancelled or self.ended:
            return
        self._cancelled = reason
        self._timers.clear(ASK)
        if not self._action:
            self._give_up(now_s)

    def wake(self, now_s: float) -> None:
        """No answer has come, or a failed manoeuvre is due again."""
        if self.phase is Phase.LOADING:
            self._ask_to_load(now_s)
        elif self.phase is Phase.UNLOADING:
            self._ask_for_dock(now_s)
        elif self.phase is Phase.HANDING_OVER:
            self._say_handover(now_s)
        else:
            self._drive(self._station, now_s)

    # --- how it is done ---

    def _enter(self, phase: Phase, station: str) -> None:
        self.phase, self._station = phase, station
        fact = PhaseEntered(task=self.task, epoch=self.epoch, phase=phase, station=station)
        self._out.append(Record(fact))

    def _drive(self, station: str, now_s: float) -> None:
        away = self._driver.go(self._plant.node_of(station), now_s)
        arrives_s = self._driver.arrives_s if away else now_s
        if self.phase is Phase.APPROACHING:
            loaded_s = self._routes.duration_s(
                self._plant.node_of(self.source), self._plant.node_of(self.work.destination)
            )
            self.due_s = arrives_s + self._type.load_s + loaded_s + self._type.unload_s
        elif self.phase is Phase.CARRYING:
            self.due_s = arrives_s + self._type.unload_s
        if not away:
            self.arrived(now_s)

    def _ask_to_load(self, now_s: float) -> None:
        if self.source == self.coordinator:
            self._ask_for_dock(now_s)
        else:
            self._pick()

    def _ask_for_dock(self, now_s: float) -> None:
        docked = Docked(task=self.task, epoch=self.epoch, station=self._station)
        self._out.append(Send(self.coordinator, docked))
        self._timers.set(ASK, now_s + ASK_AGAIN_S)

    def _waits_at(self, station: str) -> bool:
        asking = self.phase is Phase.LOADING or self.phase is Phase.UNLOADING
        return asking and station == self._station and not self._action

    def _transfer(self) -> None:
        if self.phase is Phase.LOADING:
            self._pick()
        else:
            self._drop()

    def _pick(self) -> None:
        self._action = self._driver.next_order()
        self._driver.act(
            Pick(
                order=self._action,
                station=self.source,
                item=self.work.item,
                quantity=self.work.quantity,
            )
        )

    def _drop(self) -> None:
        self._action = self._driver.next_order()
        self._driver.act(Drop(order=self._action, station=self._station))

    def _say_handover(self, now_s: float) -> None:
        handover = Handover(task=self.task, epoch=self.epoch, quantity=self.work.quantity)
        self._out.append(Send(self.coordinator, handover))
        self._timers.set(ASK, now_s + ASK_AGAIN_S)

    def _give_up(self, now_s: float) -> None:
        if self._loaded:
            self._return(now_s)
        else:
            self._end(self._cancelled)

    def _return(self, now_s: float) -> None:
        """Bring the load to the nearest storage that keeps it, or back to where it came from."""
        stored = self.work.item in self._plant.materials
        refuges = self._plant.storages_of(self.work.item) if stored else (self.source,)
        here = self._driver.next_node
        nearest = min(refuges, key=lambda each: self._routes.duration_s(here, self._plant.node_of(each)))
        self._enter(Phase.RETURNING, nearest)
        self._drive(nearest, now_s)

    def _end(self, reason: str) -> None:
        self.ended = reason
        self._timers.clear(ASK)
