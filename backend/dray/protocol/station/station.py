"""The station of a storage: tells what lies there and what is promised, and opens its dock for who may fetch it.

Whoever coordinates transports asks it to set material aside before anybody is hired (`sourcing`); what is promised
is written down before it is said. Like a machine it has a dock: a vehicle asks before it loads. What is brought back is
put down without a question, for whoever brings it has nowhere else to go.

How material comes to the storage is its body's concern; the station only tells it what is short (`Refill`).
"""

from __future__ import annotations

from dray.body import BodyState, Refill, StockChanged, StorageState
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, Memory, Note, StationMemory
from dray.messages import (
    Docked,
    StationHeartbeat,
    StockAsked,
    StockFreed,
    StockLevel,
    StockReserved,
    StockShort,
)
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.dock import Door
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import interval_s
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import Ignore, Instruct, Publish, Send
from dray.protocol.runtime.heartbeat_timer import BEAT, HeartbeatTimer
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S
from dray.protocol.runtime.trust import Trusts, trusts_nobody
from dray.protocol.station.reservations import Ask, Reservations
from dray.protocol.traffic.books.bookkeeping import Bookkeeping
from dray.protocol.traffic.traffic_map import TrafficMap

LAPSE = "lapse"

NOT_KEPT = "asked for what is not kept here"
TOO_MANY = "asked for more than anybody needs"
ANOTHERS = "about a task that another one has asked for"
FETCHED = "asked again for what was fetched"
DRAINING = "asked for while the station was draining"


class Station(AgentBase):
    """The station of one storage.

    Args:
        storage: its id in the plant, which is the station's.
        plant: the plant it stands in.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        traffic: of the plant; None where vehicles drive without right of way.
        trusts: whose word counts when people carry vehicles away.
    """

    def __init__(
        self,
        storage: str,
        plant: Plant,
        *,
        incarnation: int = 1,
        software: str = "",
        traffic: TrafficMap | None = None,
        trusts: Trusts = trusts_nobody,
    ) -> None:
        super().__init__(storage, incarnation, leaves_within_s=COORDINATOR_LEAVES_WITHIN_S)
        self._software = software
        self._beat_key = Keys(plant.id).station_heartbeat(storage)
        self._heartbeat_timer = HeartbeatTimer(self.id, self._timers)
        self._door = Door(self._out)
        self._book = Reservations({kept.material: kept.capacity for kept in plant.storages[storage].stocks})
        self._told: tuple[StockLevel, ...] = ()
        self._written: Note = StationMemory()
        self._message_handlers = {
            StockAsked: self._on_asked,
            StockFreed: self._on_freed,
            Docked: self._on_docked,
        }
        self._report_handlers = {StockChanged: self._stock_changed}
        subscriptions = HeartbeatSubscriptions(Keys(plant.id).atv_heartbeat, self._out)
        self._bookkeeping = Bookkeeping(
            storage, plant, traffic, trusts, subscriptions, self._timers, self._out
        )
        self._message_handlers = self._bookkeeping.handlers(self._message_handlers)
        self._committers += self._bookkeeping.committers
        self._alarm_handlers = {BEAT: self._beat, LAPSE: self._lapse, **self._bookkeeping.alarms}

    # --- the beginning, time passing, and the end ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        state = self._storage(body)
        self._book.take_count(state.stock, state.seq)
        note = memory.get(WHOLE)
        if isinstance(note, StationMemory):
            self._written = note
            for reserved in note.reserved:
                self._book.restore(reserved, state.opened, now_s)
        self._go_on(now_s)
        self._bookkeeping.start(memory, now_s)
        self._heartbeat_timer.at_once(now_s)

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        state = self._storage(body)
        self._book.sense(state.stock, state.seq)

    def _storage(self, body: BodyState | None) -> StorageState:
        if not isinstance(body, StorageState):
            raise ProtocolViolation(f"{self.id}: a station needs a storage, not {body!r}")
        return body

    def _memory(self) -> Note:
        return self._written

    def _beat(self, _about: None, now_s: float) -> None:
        self._heartbeat_timer.go_on(interval_s(self._say_status(now_s)), now_s)

    def _say_status(self, now_s: float) -> StationHeartbeat:
        heartbeat = StationHeartbeat(
            station=self.id,
            incarnation=self.incarnation,
            seq=self._heartbeat_timer.count(),
            at_s=now_s,
            stocks=self._told,
            software=self._software,
            draining=self._shutdown.begun,
            awaits=self._bookkeeping.awaited(now_s),
        )
        self._out.append(Publish(self._beat_key, heartbeat))
        return heartbeat

    def _prepare_to_leave(self, now_s: float) -> None:
        self._heartbeat_timer.at_once(now_s)

    def _is_held(self) -> bool:
        return any(ask.opened for ask in self._book)

    def _take_leave(self, now_s: float) -> None:
        self._say_status(now_s)

    # --- who counts on what ---

    def _on_asked(self, sender: str, asked: StockAsked, now_s: float) -> None:
        known = self._book.get(asked.task)
        if reason := self._refusal(sender, asked, known):
            self._out.append(Ignore(reason))
            return
        ask = self._book.ask(asked, sender, now_s)
        if ask.reserved:
            self._say_reserved(ask)
        self._go_on(now_s)
        if not ask.reserved:
            self._say_short(ask)

    def _refusal(self, sender: str, asked: StockAsked, known: Ask | None) -> str:
        """Why a question is not answered; empty when it is."""
        if not self._book.holds(asked.item, asked.quantity):
            return NOT_KEPT
        if self._book.was_taken(asked.task, asked.epoch):
            return FETCHED
        if known is not None:
            same = (known.item, known.quantity) == (asked.item, asked.quantity)
            return "" if same and known.coordinator in ("", sender) else ANOTHERS
        if self._shutdown.begun:
            return DRAINING
        return TOO_MANY if self._book.has_too_many(sender) else ""

    def _on_freed(self, sender: str, freed: StockFreed, now_s: float) -> None:
        ask = self._book.get(freed.task)
        if ask is None or ask.coordinator != sender:
            self._out.append(Ignore("gave back what it does not have"))
            return
        self._release(ask)
        self._go_on(now_s)

    def _lapse(self, _about: None, now_s: float) -> None:
        for ask in self._book.lapsed(now_s):
            self._release(ask)
        self._go_on(now_s)

    def _release(self, ask: Ask) -> None:
        self._book.release(ask)
        if ask.opened:
            self._door.shut(ask.vehicle)

    # --- the dock ---

    def _on_docked(self, sender: str, docked: Docked, now_s: float) -> None:
        """A vehicle stands here and asks to load."""
        if docked.station != self.id:
            self._out.append(Ignore("asked for the dock of another storage"))
            return
        ask = self._book.get(docked.task)
        if ask is None or not ask.reserved:
            ask = self._stand(sender, docked, now_s)
        if ask is None:
            self._door.hold(sender, docked, f"{self.id} does not keep this")
        elif not ask.reserved:
            self._door.hold(sender, docked, f"{self.id} has no {ask.item}")
        elif ask.vehicle != sender and docked.epoch <= ask.opened:
            self._door.hold(sender, docked, "another vehicle fetches it")
        else:
            self._open(sender, docked, ask, now_s)

    def _stand(self, sender: str, docked: Docked, now_s: float) -> Ask | None:
        """Nothing is set aside for its task; it waits before all others, for as long as it asks."""
        if not self._book.holds(docked.item, docked.quantity):
            return None
        asked = StockAsked(docked.task, docked.epoch, docked.item, docked.quantity)
        ask = self._book.stand(sender, asked, now_s)
        self._go_on(now_s)
        return ask

    def _open(self, vehicle: str, docked: Docked, ask: Ask, now_s: float) -> None:
        if ask.opened and ask.vehicle != vehicle:
            self._door.shut(ask.vehicle)
        ask.vehicle, ask.opened, ask.epoch = vehicle, docked.epoch, max(ask.epoch, docked.epoch)
        self._book.renew(ask, now_s)
        self._door.open(vehicle, docked, ask.item, ask.quantity)
        self._go_on(now_s)

    def _stock_changed(self, report: StockChanged, now_s: float) -> None:
        self._book.change(report.item, report.change, report.seq)
        if report.change < 0:
            self._book.take(report.vehicle, report.item)
        self._go_on(now_s)

    # --- what follows ---

    def _go_on(self, now_s: float) -> None:
        """See to all that follows from a change: promises, what cannot be kept, what is short, when to look again."""
        for ask in self._book.overdrawn():
            if ask.vehicle:
                self._door.shut(ask.vehicle)
            self._say_short(ask)
        for ask in self._book.promise(now_s):
            self._say_reserved(ask)
        self._out.extend(Instruct(Refill(item=item)) for item in self._book.short_items)
        self._timers.set(LAPSE, self._book.next_lapse_s)
        if (levels := self._book.levels()) != self._told:
            self._told = levels
            self._heartbeat_timer.at_once(now_s)
        if (memory := StationMemory(reserved=self._book.memories())) != self._written:
            self._written = memory
            self._commit()

    def _say_reserved(self, ask: Ask) -> None:
        if ask.coordinator:
            reserved = StockReserved(task=ask.task, epoch=ask.epoch, item=ask.item, quantity=ask.quantity)
            self._out.append(Send(ask.coordinator, reserved))

    def _say_short(self, ask: Ask) -> None:
        if ask.coordinator:
            free = max(0, self._book.free(ask.item))
            short = StockShort(task=ask.task, epoch=ask.epoch, item=ask.item, free=free)
            self._out.append(Send(ask.coordinator, short))
