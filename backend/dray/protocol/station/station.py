"""The station of a storage or source warehouse: it reports stock and reservations, and opens its dock.

A coordinator asks it to set material aside before it hires a vehicle (`transports.issuing`). Reservations are
stored before they are confirmed. It has a dock like a machine: a vehicle asks before it loads. A vehicle that
returns a load asks too, and is let in, because it has no other place. Transports ordered to this place are
coordinated by the same code as a machine's (`transports.transport_flow`).

If vehicles refill the storage, the station orders what runs low (`refilling`). Otherwise material comes by its body
or by people. The station tells the body what is short, and how far it may fill (`self_filling`).
"""

from __future__ import annotations

from msgspec import UNSET
from msgspec.structs import replace

from dray.body import BodyState, DockReady, StockChanged, StorageState, WordTaken
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, Memory, Note, ReservationMemory, StationMemory, visits_of
from dray.messages import Docked, MachineCommand, StationHeartbeat, StockLevel, TransportOrdered, WorkSought
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.calls.help_calls import NotComing
from dray.protocol.closures.closure_listener import ClosureListener
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.changes import TaskDelivered, TaskLost
from dray.protocol.liveness.suspicion import interval_s
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.life import BEAT, Change
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S
from dray.protocol.runtime.trust import Trusts, trusts_nobody
from dray.protocol.station.held_loads import HeldLoads
from dray.protocol.station.refilling import Refilling
from dray.protocol.station.self_filling import SelfFilling
from dray.protocol.traffic.reservations.reservation_handling import CarriedAway, ReservationHandling
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.transports.carrier_waits import docks_heard
from dray.protocol.transports.handovers import CountMissed
from dray.protocol.transports.issuing import Issuing, ReservationsChanged
from dray.protocol.transports.reservations import Reservations
from dray.protocol.transports.transport_flow import MaterialChanged, TransportFlow


class Station(AgentBase):
    """The station of one storage or source warehouse.

    Args:
        storage: its id in the plant, and the station's id.
        plant: its plant.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        traffic: of the plant; None if vehicles drive without right of way.
        trusts: the trusted signers of people's removals and commands.
        rules: time-outs and radius of its auctions.
    """

    def __init__(
        self,
        storage: str,
        plant: Plant,
        *,
        incarnation: int = 1,
        software: str = "",
        rules: AuctionRules | None = None,
        traffic: TrafficMap | None = None,
        trusts: Trusts = trusts_nobody,
    ) -> None:
        super().__init__(storage, incarnation, leaves_within_s=COORDINATOR_LEAVES_WITHIN_S)
        self._software = software
        self._beat_key = Keys(plant.id).station_heartbeat(storage)
        plant = KnownFloor(plant)
        self._closures = ClosureListener(plant, trusts, self._life)
        self._keys = Keys(plant.id)
        spec = plant.stores[storage]
        items = tuple(kept.material for kept in spec.stocks)
        self._book = Reservations({kept.material: kept.capacity for kept in spec.stocks})
        self._uncounted: tuple[str, ...] = ()
        """Materials whose stock its body does not know."""
        self._told: tuple[StockLevel, ...] = ()
        self._written: tuple[ReservationMemory, ...] = ()
        self._flow = TransportFlow(
            storage,
            plant,
            self._keys,
            items,
            self._book,
            rules or AuctionRules(),
            self._life,
        )
        self._issuing = Issuing(
            storage,
            self._book,
            self._life,
            self._flow.door,
            self._shutdown,
        )
        authority = CommandAuthorisation(storage, plant, trusts)
        self._held_loads = HeldLoads(plant, self._flow.held, self._flow.goods_recovery, authority, self._life)
        self._self_filling = SelfFilling(spec, plant, self._book, self._flow, self._life)
        self._refilling = Refilling(spec, plant, self._book, self._flow, self._life)
        self._message_handlers = {
            **self._flow.message_handlers,
            **self._issuing.message_handlers,
            **self._closures.message_handlers,
            **self._held_loads.message_handlers,
            MachineCommand: self._on_command,
            Docked: self._on_docked,
            TransportOrdered: self._on_ordered,
            WorkSought: self._on_sought,
        }
        self._report_handlers = {
            StockChanged: self._stock_changed,
            DockReady: self._flow.on_dock_ready,
            WordTaken: self._word_taken,
        }
        self._docks = () if traffic is None else docks_heard(storage, items, plant, self._keys)
        self._reservation_handling = ReservationHandling(
            storage, plant, traffic, trusts, self._flow.subscriptions, self._life
        )
        self._message_handlers = self._reservation_handling.handlers(self._message_handlers)
        self._committers += [*self._reservation_handling.committers, self._flow.called.commits]
        self._reactions = {
            **self._flow.reactions,
            TaskLost: self._on_lost,
            TaskDelivered: self._on_delivered,
            CarriedAway: lambda carried, _now_s: self._flow.on_carried_away(carried.vehicle),
            MaterialChanged: lambda _change, now_s: self._go_on(now_s),
            ReservationsChanged: lambda _change, now_s: self._go_on(now_s),
            # Its calls are about goods, and its loads belong to no goal.
            NotComing: _nothing_follows,
            CountMissed: _nothing_follows,
        }
        self._alarm_handlers = {
            BEAT: self._beat,
            **self._closures.alarms,
            **self._issuing.alarms,
            **self._flow.alarms,
            **self._held_loads.alarms,
            **self._reservation_handling.alarms,
        }

    # --- the beginning, time passing, and the end ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        state = self._storage(body)
        self._book.take_count(state.stock, state.seq)
        self._uncounted = state.uncounted
        self._flow.take_abilities(state)
        self._held_loads.sense(state)
        note = memory.get(WHOLE)
        if isinstance(note, StationMemory):
            self._written = note.reserved
            for reserved in note.reserved:
                self._book.restore(reserved, state.opened, now_s)
            self._flow.restore_tasks(note.tasks, memory, now_s)
            self._flow.visits.restore(visits_of(note))
            self._flow.visits.doubts.restore(note.doubts)
            self._flow.bookings.restore(note.booked)
            self._held_loads.restore(note.answered)
            # Tasks without a carrier have a higher epoch now, which no later life may reuse.
            self._life.commit()
        else:
            self._flow.restore_tasks((), memory, now_s)
        bringing = {task.primary for task in self._flow.tasks}
        self._issuing.shut_unknown(vehicle for vehicle in state.opened if vehicle not in bringing)
        self._flow.dismiss(state.gone)
        self._life.subscribe(self._keys.all_free)
        self._life.do(*self._docks)
        self._closures.listen()
        if self.incarnation > 1:
            self._flow.recover(not memory, now_s)
        self._go_on(now_s)
        self._reservation_handling.start(memory, now_s, dock_answers=self._flow.visits.answers)
        self._life.beat_soon(now_s)

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        state = self._storage(body)
        if self._held_loads.sense(state):
            self._life.beat_soon(now_s)
        was, self._uncounted = self._uncounted, state.uncounted
        if self._book.sense(state.stock, state.seq) or was != state.uncounted:
            self._go_on(now_s)

    def _storage(self, body: BodyState | None) -> StorageState:
        if not isinstance(body, StorageState):
            raise ProtocolViolation(f"{self.id}: a station needs a storage, not {body!r}")
        return body

    def _memory(self) -> Note:
        return StationMemory(
            reserved=self._written,
            tasks=tuple(task.memory() for task in self._flow.tasks),
            answered=self._held_loads.answered,
            visits=self._flow.visits.memories(),
            booked=self._flow.bookings.memories(),
            doubts=self._flow.visits.doubts.memories(),
        )

    def _was_deaf(self, span_s: float) -> None:
        self._flow.subscriptions.arrivals.deaf_s += span_s

    def _beat(self, _about: None, now_s: float) -> None:
        if self._flow.called:
            self._go_on(now_s)
        self._held_loads.update_calls(now_s, expected=not self._shutdown.begun)
        self._life.beat_again(interval_s(self._say_status(now_s)), now_s)

    def _say_status(self, now_s: float) -> StationHeartbeat:
        heartbeat = StationHeartbeat(
            station=self.id,
            incarnation=self.incarnation,
            seq=self._life.count_beat(),
            at_s=now_s,
            stocks=self._told,
            tasks=tuple(task.brief() for task in self._flow.tasks),
            waits=self._flow.sourcing.waits(),
            software=self._software,
            draining=self._shutdown.begun,
            awaits=self._reservation_handling.awaited(now_s),
            dock_wait=self._flow.door.wait(now_s),
            people=self._held_loads.people or UNSET,
            doubts=self._flow.visits.doubts.told(),
        )
        self._life.publish(self._beat_key, heartbeat)
        return heartbeat

    def _prepare_to_leave(self, now_s: float) -> None:
        self._flow.drop_needs()
        self._life.beat_soon(now_s)

    def _is_held(self) -> bool:
        return self._issuing.is_held or self._flow.is_held

    def _take_leave(self, now_s: float) -> None:
        self._say_status(now_s)

    # --- messages and reports ---

    def _on_docked(self, sender: str, docked: Docked, now_s: float) -> None:
        """A vehicle stands here and asks to unload, or to load for another place."""
        if docked.returns and docked.station == self.id:
            is_kept = self._book.holds(docked.item, docked.quantity)
            self._flow.take_back(sender, docked, now_s, is_kept=is_kept)
            self._self_filling.pursue()
        elif docked.station != self.id and not self._flow.knows(docked.task):
            self._life.ignore("a request for the dock of another storage")
        elif docked.item and docked.station == self.id and not self._flow.knows(docked.task):
            self._issuing.on_docked(sender, docked, now_s)
        else:
            self._flow.message_handlers[Docked](sender, docked, now_s)

    def _on_command(self, sender: str, command: MachineCommand, now_s: float) -> None:
        self._held_loads.on_command(sender, command, now_s)
        self._life.commit()
        self._go_on(now_s)
        self._life.beat_soon(now_s)

    def _on_ordered(self, sender: str, order: TransportOrdered, now_s: float) -> None:
        self._flow.message_handlers[TransportOrdered](sender, order, now_s)
        self._go_on(now_s)

    def _on_sought(self, sender: str, message: WorkSought, now_s: float) -> None:
        if not self._shutdown.begun:
            self._flow.offer(sender, message, now_s)

    def _word_taken(self, report: WordTaken, _now_s: float) -> None:
        if (word := self._held_loads.words.on_taken(report)) is not None:
            self._flow.held.on_word(word)

    def _stock_changed(self, report: StockChanged, now_s: float) -> None:
        self._book.change(report.item, report.change, report.seq)
        self._flow.on_material(report, self._flow.note_booked(report), now_s)
        if report.change < 0:
            self._issuing.on_taken(report.vehicle, report.item)
        self._go_on(now_s)

    # --- consequences ---

    def _on_lost(self, lost: TaskLost, now_s: float) -> None:
        self._flow.on_lost(lost, now_s)
        self._go_on(now_s)

    def _on_delivered(self, delivered: TaskDelivered, now_s: float) -> None:
        self._flow.on_delivered(delivered, now_s)
        self._go_on(now_s)

    def _go_on(self, now_s: float) -> None:
        """Update reservations, orders, refills and the heartbeat after a change."""
        self._issuing.settle(now_s)
        if not self._shutdown.begun:
            self._flow.called.pursue(now_s)
            if not self._flow.hears_out:
                self._refilling.pursue(now_s, self._uncounted)
        self._flow.called.review(now_s)
        self._self_filling.pursue()
        levels = tuple(
            replace(
                level,
                on_order=self._flow.on_order(level.item),
                uncounted=level.item in self._uncounted,
            )
            for level in self._book.levels()
        )
        if levels != self._told:
            self._told = levels
            self._life.beat_soon(now_s)
        if (reserved := self._book.memories()) != self._written:
            self._written = reserved
            self._life.commit()


def _nothing_follows(_change: Change, _now_s: float) -> None:
    """The reaction to a change that cannot come from this agent's parts, and would ask nothing of it."""
