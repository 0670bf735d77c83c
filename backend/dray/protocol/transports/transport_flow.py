"""The transports to one machine or storage: requested, fetched, counted, and recovered after a restart.

This class joins the parts: the transports in `transports`, their sources in `sourcing`, the dock in `dock`,
carriers' reports in `handovers`, orders of people and programs in `called`. They note what has changed; the agent
reacts to it with the methods of this class. A machine's own orders and finished goods are added in
`dray.protocol.machine.material_flow`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from dray.body import DockReady, StockChanged, StorageState, WorkcellState
from dray.memory import DepartureMemory, Memory, TaskMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    Declined,
    Docked,
    DockExpected,
    Handover,
    Message,
    Resigned,
    StockReserved,
    StockShort,
    TakenOver,
    Transport,
    TransportCancelled,
    TransportOrdered,
    WorkSought,
)
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.changes import ContractChanged, TaskDelivered, TaskLost
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.life import Change, Life
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.called import CalledTransports
from dray.protocol.transports.dock import Dock
from dray.protocol.transports.dock_door import IN_DOUBT, Door, ready_within_s
from dray.protocol.transports.goods_recovery import GoodsRecovery
from dray.protocol.transports.handovers import Handovers
from dray.protocol.transports.held import HeldTransports
from dray.protocol.transports.lead_time import first_lead_s
from dray.protocol.transports.receiving import GateCount
from dray.protocol.transports.recovery import RECOVERY_WAIT, Recovery
from dray.protocol.transports.sourcing import MaterialGone, MaterialReserved, Need, NeedReduced
from dray.protocol.transports.transports import Stock, Transports
from dray.protocol.transports.visits import Visits

NOT_REMEMBERED = "a message about a task that may be of an earlier life without notes"

NOT_KEPT = "a returned load that is not kept here, or for which there is no room"

HELD_MAX_S = 60.0
"""How long a vehicle may wait for room (s): two or three cycles of a working machine."""


@dataclass(frozen=True, slots=True)
class MaterialChanged(Change):
    """What is here or on its way is known better, or has become less."""


class TransportFlow:
    """The transports to one place.

    Args:
        place: its id in the plant, and its agent's id.
        plant: its plant.
        keys: the plant's bus keys.
        items: the items that may be brought to it.
        stock: its stock.
        rules: time-outs and radius of its auctions.

    Attributes:
        tasks: its open transports.
        sourcing: needs without a hired vehicle.
        held: transports whose loads a person must look for.
        goods_recovery: goods and things on board of failed vehicles.
        called: transports ordered by people and programs.
        door: the door of its dock, for all who load or unload.
        bookings: reports that its body has not answered.
        visits: the vehicles at its dock.
        message_handlers: by message type, handlers called with (sender, message, now_s).
        alarms: handlers of these alarms.
        reactions: by kind of change, reactions to what changes in its parts and needs nothing else of its agent.
        subscriptions: its heartbeat subscriptions.
    """

    def __init__(
        self,
        place: str,
        plant: Plant,
        keys: Keys,
        items: Collection[str],
        stock: Stock,
        rules: AuctionRules,
        life: Life,
    ) -> None:
        self._place, self._plant = place, plant
        self._life = life
        self.subscriptions = HeartbeatSubscriptions(keys.atv_heartbeat, life)
        self.bookings = Bookings(life)
        self.visits = Visits(plant.node_of(place), self.subscriptions, self.bookings, life)
        self.door = Door(self.visits, ready_within_s(plant, place), life)
        self.tasks = Transports(
            place,
            plant,
            keys,
            stock,
            rules,
            life,
            self.subscriptions,
            self.door,
            Assessor(plant, life),
        )
        self.sourcing = self.tasks.sourcing
        self.held = HeldTransports(plant, self.tasks, self.visits, self.bookings)
        self.goods_recovery = GoodsRecovery(plant, self.tasks, self.held)
        self._dock = Dock(place, self.tasks, stock, self.door, life)
        self._handovers = Handovers(
            place,
            self.tasks,
            self._counted_of,
            self._dock,
            self.bookings,
            life,
        )
        self._recovery = Recovery(place, plant, self.subscriptions, self.tasks, stock, life, items=items)
        self.called = CalledTransports(place, plant, stock, self, life)
        self.message_handlers: dict[type[Message], Callable[..., None]] = {
            AtvHeartbeat: self._on_vehicle,
            Bid: self.tasks.on_bid,
            Accepted: self._on_accepted,
            Declined: self.tasks.on_declined,
            Resigned: self._on_resigned,
            StockReserved: self.sourcing.on_reserved,
            StockShort: self.sourcing.on_short,
            TakenOver: self._on_taken_over,
            Docked: self._on_docked,
            DockExpected: self.tasks.waits.on_expected,
            Handover: self._handovers.on_handover,
            TransportOrdered: self._on_ordered,
            TransportCancelled: self._on_cancelled,
        }
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {
            RECOVERY_WAIT: self._end_recovery,
            **self.tasks.alarms,
            **self.called.alarms,
        }
        self.reactions: Mapping[type[Change], Callable[[Any, float], None]] = {
            ContractChanged: self._on_contract_changed,
            MaterialReserved: self._on_reserved,
            MaterialGone: self._on_gone,
            NeedReduced: self._on_reduced,
        }

    def take_abilities(self, body: WorkcellState | StorageState) -> None:
        """Take over what the body can count and report by itself."""
        self._handovers.counts = self.visits.counts = body.counts
        self.visits.answers = body.answers
        if isinstance(body, StorageState):
            self.visits.doubts.measured = frozenset(body.measured)
        self.visits.restore_opened(body.opened)

    def take_back(self, vehicle: str, docked: Docked, now_s: float, *, is_kept: bool) -> None:
        """Take a load back that is not awaited any more; a body that counts and opens at once needs no check.

        It has its room from now on, until it is counted or the vehicle has left with it.

        Args:
            vehicle: its id.
            docked: its request.
            now_s: the present time.
            is_kept: whether the load can lie here; otherwise it is taken without a booking.
        """
        counts = self._handovers.counts
        if not is_kept and not counts:
            self._life.ignore(NOT_KEPT)
        quantity = docked.quantity if is_kept else 0
        load = DepartureMemory(vehicle, docked.task, docked.epoch, docked.item, quantity)
        if counts and not self.visits.answers:
            self.visits.take_back(load, now_s)
            self.door.agree(vehicle, docked)
            return
        # It may have taken the load here. Its next heartbeat would say so with its forks inside and the dock
        # shut.
        self.visits.on_docked(vehicle, docked, now_s, unloads=True)
        if self.visits.doubts.has_too_many(vehicle):
            self.door.hold(vehicle, docked, IN_DOUBT)
            return
        self.visits.take_back(load, now_s)
        self.door.open(vehicle, docked, docked.item, docked.quantity, now_s, comes=True)

    def restore_tasks(self, memories: Iterable[TaskMemory], memory: Memory, now_s: float) -> None:
        """Restore the transports of an earlier life, and ordered ones."""
        for kept in memories:
            if not (task := self.tasks.restore(kept, now_s)).is_held:
                self.sourcing.follow(task, now_s)
            self._on_restored(kept.work)
        self.called.restore(memory)

    def recover(self, forgetful: bool, now_s: float) -> None:
        """Listen for unknown vehicles that work for this place."""
        self._recovery.listen(forgetful, now_s)

    def _end_recovery(self, _about: None, now_s: float) -> None:
        self._recovery.stop_listening()
        self._on_recovered(now_s)
        self._life.note(MaterialChanged())

    # --- requests and reports of the agent ---

    @property
    def is_held(self) -> bool:
        """Whether an answer may still come, or a vehicle is at the dock."""
        return self.tasks.awaits_answers or any(task.is_changing_hands for task in self.tasks)

    @property
    def hears_out(self) -> bool:
        """Whether carriers may still report loads for an earlier life without notes."""
        return self._recovery.is_listening_for_all

    def knows(self, task: str) -> bool:
        """Whether a task is, or was, this place's."""
        return not (self.tasks.get(task) is None and self.tasks.closed(task) is None)

    def seek(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        """Have a load set aside at its source, and then fetched."""
        self._note_ordered(work)
        self.sourcing.seek(task, self._docked_here(work), deadline_s, now_s)

    def drop(self, task: str) -> None:
        """Drop the need for a load without a hired vehicle."""
        for need in list(self.sourcing):
            if need.task == task:
                self._drop(need)

    def drop_needs(self) -> None:
        """Drop all needs without a hired vehicle."""
        for need in list(self.sourcing):
            self._drop(need)
            for called in self.called:
                if called.task == need.task:
                    called.task = ""

    def inbound(self, item: str) -> int:
        """Pieces that are to find room here: on order, or put down without an order."""
        return self.on_order(item) + self._put_back(item)

    def on_order(self, item: str) -> int:
        """Pieces on their way to this place, or ordered to it."""
        works = [*(cast(Transport, task.work) for task in self.tasks), *(need.work for need in self.sourcing)]
        return self._to_here(item, works)

    def carried(self, item: str) -> int:
        """Those of them that have a carrier."""
        works = [cast(Transport, task.work) for task in self.tasks if task.primary]
        return self._to_here(item, works) + self._put_back(item)

    def offer(self, sender: str, message: WorkSought, now_s: float) -> None:
        """Offer a waiting transport to a vehicle that asks for work."""
        if not self.tasks.offer(sender, message.abilities, now_s):
            self._life.ignore("a request for work while none waits")

    def on_dock_ready(self, report: DockReady, now_s: float) -> None:
        """The body has opened the dock for a vehicle."""
        self._dock.on_ready(report.vehicle, now_s)
        self._life.beat_soon(now_s)

    def on_carried_away(self, vehicle: str) -> None:
        """People have carried a vehicle away: it is outside, and its requests are dropped."""
        self.visits.on_carried_away(vehicle)
        self._life.note(MaterialChanged())

    def dismiss(self, gone: Iterable[str]) -> None:
        """Tell the body which of these vehicles will not report any more."""
        for vehicle in gone:
            if self.visits.get(vehicle) is None:
                self.visits.dismiss(vehicle)

    def note_booked(self, report: StockChanged) -> DepartureMemory | None:
        """The body has counted or booked a vehicle's load. Returns the agent's report that it answers; None for none."""
        if not report.vehicle:
            return None
        word = self.bookings.on_stock_changed(report)
        self.door.note_moved(report, word)
        if report.change > 0:
            self.visits.note_brought(report.vehicle)
        return word

    def on_material(self, report: StockChanged, word: DepartureMemory | None, now_s: float) -> None:
        """Material has come, or was taken; `word`: the agent's report that the body answers."""
        self._handovers.on_stock_changed(report, word, now_s)

    # --- what follows from changes ---

    def _on_reserved(self, reserved: MaterialReserved, now_s: float) -> None:
        """Announce a transport whose load is set aside."""
        need = reserved.need
        self._announce(need.task, need.work, self._latest_s(need, now_s), now_s)

    def _announce(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        self.tasks.open(task, work, deadline_s, now_s)
        self._life.commit()
        self._life.beat_soon(now_s)

    def _drop(self, need: Need) -> None:
        """Drop a need without a hired vehicle."""
        self.sourcing.drop(need)
        self._note_settled(need.work, None)

    def _on_ordered(self, sender: str, order: TransportOrdered, now_s: float) -> None:
        if self.hears_out:
            self._life.ignore(NOT_REMEMBERED)
        else:
            self.called.on_ordered(sender, order, now_s)

    def _on_cancelled(self, sender: str, message: TransportCancelled, _now_s: float) -> None:
        if self.called.on_cancelled(sender, message):
            # The place may have counted on the cancelled load.
            self._life.note(MaterialChanged())

    def _on_vehicle(self, _sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        self.tasks.on_heartbeat(heartbeat, now_s)
        self._handovers.on_carrier_heard(heartbeat)
        if (word := self._recovery.moved(heartbeat)) is not None:
            self.visits.on_word(word, heartbeat.node)
        was_here = self.visits.waits_for(heartbeat.atv)
        self.visits.on_vehicle(heartbeat, now_s)
        if was_here and not self.visits.waits_for(heartbeat.atv):
            self._life.note(MaterialChanged())
        if (recovered := self._recovery.on_heartbeat(heartbeat, now_s)) is not None:
            self._note_ordered(recovered)
        self.called.review(now_s)

    def _on_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        if self._is_remembered(answer.task):
            self.tasks.on_accepted(sender, answer, now_s)

    def _on_taken_over(self, sender: str, message: TakenOver, now_s: float) -> None:
        if self._is_remembered(message.task):
            self.tasks.on_taken_over(sender, message, now_s)

    def _on_docked(self, sender: str, message: Docked, now_s: float) -> None:
        if not self._is_remembered(message.task):
            return
        if (task := self.tasks.get(message.task)) is not None and self.tasks.is_missing(task):
            # A lost load never comes, and the books do not show it.
            self._on_lacking(now_s)
        self._dock.on_docked(sender, message, now_s)
        task = self.tasks.get(message.task)
        if task is None or self._dock.is_opening(sender):
            return
        if now_s - task.contract.held_s > HELD_MAX_S:
            self.withdraw(task, now_s)

    def _on_resigned(self, sender: str, message: Resigned, now_s: float) -> None:
        task = self.tasks.get(message.task)
        gives_back = task is not None and (sender, message.epoch) == (task.primary, task.epoch)
        if task is None or not gives_back or not message.short or task.is_of_goods or task.is_counted:
            self.tasks.on_resigned(sender, message, now_s)
            return
        if self.sourcing.holds(task.id, message.short):
            # The station's reservation, as far as is known, contradicts this.
            self.tasks.failover.note_short(task, message.short, message.reason, now_s)
        # Another vehicle would find no more: hire none before a station has it.
        self.withdraw(task, now_s)

    def _is_remembered(self, task: str) -> bool:
        """Whether a message about a task can be handled yet; otherwise it is repeated."""
        if self._recovery.waits_for_word_on(task):
            self._life.ignore(NOT_REMEMBERED)
            return False
        return True

    def cancel(self, task: OpenTask) -> None:
        """End a transport that is not needed any more."""
        self.tasks.close(task, "withdrawn")
        self._note_settled(cast(Transport, task.work), None)
        self._life.commit()

    def withdraw(self, task: OpenTask, now_s: float) -> None:
        """End a transport that finds no room or no load, and so blocks its vehicle."""
        self.tasks.give_up(task, now_s)
        self._life.settle(now_s)

    def _on_gone(self, gone: MaterialGone, now_s: float) -> None:
        """End a transport whose load is nowhere any more."""
        self.withdraw(gone.task, now_s)

    def _on_reduced(self, reduced: NeedReduced, _now_s: float) -> None:
        """Expect a smaller load than was requested."""
        self._note_settled(reduced.before, None)
        self._note_ordered(reduced.after)

    def _on_contract_changed(self, _changed: ContractChanged, now_s: float) -> None:
        """Report the state of ordered transports."""
        self.called.review(now_s)

    def on_lost(self, lost: TaskLost, now_s: float) -> None:
        """Order a withdrawn transport anew if it is still needed."""
        self.called.on_lost(lost.task)
        self._life.commit()
        self._life.beat_soon(now_s)

    def on_delivered(self, delivered: TaskDelivered, now_s: float) -> None:
        """Count a delivered load for the transport that was ordered."""
        self.called.on_settled(delivered.task, delivered.counted)
        self._life.commit()
        self._life.beat_soon(now_s)

    def _put_back(self, item: str) -> int:
        """Pieces that are brought back here, or whose transport has ended: a vehicle may put them down, or the body may book them."""
        loads = (*self.visits.loads(), *self.bookings.memories())
        return sum(
            max(0, load.change)
            for load in loads
            if load.item == item and (load.returns or self.tasks.get(load.task) is None)
        )

    def _to_here(self, item: str, works: Iterable[Transport]) -> int:
        return sum(work.quantity for work in works if work.destination == self._place and work.item == item)

    # --- hooks for a machine: the default place neither makes nor uses anything ---

    def _latest_s(self, need: Need, now_s: float) -> float:
        """Deadline of a load that can be fetched only now (plant clock)."""
        return max(need.deadline_s, now_s + first_lead_s(self._plant, self._place, need.work.sources))

    def _docked_here(self, work: Transport) -> Transport:
        """A transport in the form that others need."""
        return work

    def _note_ordered(self, work: Transport) -> None:
        """A load is to come."""

    def _note_settled(self, work: Transport, took_s: float | None) -> None:
        """A load was cancelled, or has come after `took_s`."""

    def _on_restored(self, work: Transport) -> None:
        """A task of an earlier life was restored."""

    def _on_recovered(self, now_s: float) -> None:
        """The recovery wait is over: all carriers of an earlier life were heard."""

    def _on_lacking(self, now_s: float) -> None:
        """The load of a task is gone from here."""

    def _counted_of(self, goal: str) -> GateCount | None:
        """The gate's count of a goal; None if no goal wants it."""
        return None
