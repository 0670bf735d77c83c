"""A coordinator's transports: from the first announcement to the end, with failure detection of the carriers.

Beyond the common coordinator (`coordinator`), a transport has a secondary while it can be taken over
(`secondaries`). Its primary is replaced when it fails (`failover`), and the transport outlives a restart of its
coordinator.

    AUCTION --accepted--> CARRIED --delivered, withdrawn--> closed
       ^                    |  ^
       |                    |  +-- taken over: epoch + 1, another carrier
       +--- epoch + 1 ------+ no carrier any more; if its primary has given it back,
                              the secondary is asked before the announcement

After two disputed handovers it is held, not announced again, until a person has looked (`held`). So it is when its
carrier may have put the load down and has forgotten it, and when carriers have failed at one dock.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Protocol, cast

from dray.memory import DepartureMemory, TaskMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    Brief,
    Confirmed,
    Declined,
    Phase,
    Reason,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    Transport,
    Wait,
    Withdrawn,
    Work,
)
from dray.messages.fact import Outcome
from dray.messages.heartbeat import GOODS_ABOARD
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.auction_rules import AuctionRules, prolonged_s
from dray.protocol.contract_net.changes import TaskDelivered, TaskLost
from dray.protocol.contract_net.coordinator import PRIMARY_AUCTION, Coordinator
from dray.protocol.contract_net.task import CarrierContract, OpenTask
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.contract_net.terms import Place
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.contract_net.trust.plausibility import by_our_clock
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, WORKING_INTERVAL_S
from dray.protocol.runtime.life import Life
from dray.protocol.takeover.failover import Failover
from dray.protocol.takeover.secondaries import Secondaries
from dray.protocol.transports.carrier_waits import ONE_AFTER_ANOTHER_S, CarrierWaits
from dray.protocol.transports.dock_door import Door
from dray.protocol.transports.sourcing import Sourcing

RECOVERY_WAIT_S = 10.0
"""How long a restarted coordinator listens for vehicles that work for it (s): many heartbeats."""


def stands_back(task: OpenTask, others: Iterable[OpenTask]) -> bool:
    """Whether a more urgent task waits for the same vehicles after a failed round."""
    wanted, urgency = _wanted(task), _urgency(task)
    return any(
        other.auction.was_in_vain and _wanted(other) == wanted and _urgency(other) < urgency
        for other in others
    )


def most_urgent(tasks: Iterable[OpenTask], atv: str, abilities: Collection[str]) -> OpenTask | None:
    """The most urgent waiting task for a vehicle with these abilities; None if there is none."""
    waiting = [
        task
        for task in tasks
        if task.auction.waits
        and _wanted(task)[1] in ("", atv)
        and all(ability in abilities for ability in _wanted(task)[0])
    ]
    return min(waiting, key=_urgency, default=None)


def _wanted(task: OpenTask) -> tuple[tuple[str, ...], str]:
    """The abilities that a task needs, and its only permitted vehicle; empty for any."""
    work = cast(Transport, task.work)
    return work.needed, work.vehicle


def _urgency(task: OpenTask) -> tuple[float, str]:
    return task.auction.needed_s, task.id


class Stock(Protocol):
    """The stock at a coordinator's place."""

    def level(self, item: str) -> int:
        """Pieces in stock."""

    def room(self, item: str) -> int:
        """Pieces for which there is room."""

    def lacks_goods(self, item: str, quantity: int) -> bool:
        """Whether fewer pieces of an item lie there, of which every piece exists once."""


class Transports(Coordinator):
    """All open transports of one coordinator. It notes what has changed (`dray.protocol.contract_net.changes`).

    Args:
        place: the coordinator's place in the plant, and its id.
        plant: its plant.
        keys: the plant's bus keys.
        stock: its stock.
        rules: the auctions' time-outs and radius.
        subscriptions: its heartbeat subscriptions.
        door: the door of its dock.
        assessor: checks bids, and rates carriers.

    Attributes:
        sourcing: needs without a hired vehicle, and the material that is set aside for transports.
        failover: the failover of its carriers.
        reliability: the ratings of its carriers.
        waits: known waits and expected vehicles at the places of its transports.
    """

    def __init__(
        self,
        place: str,
        plant: Plant,
        keys: Keys,
        stock: Stock,
        rules: AuctionRules,
        life: Life,
        subscriptions: HeartbeatSubscriptions,
        door: Door,
        assessor: Assessor,
    ) -> None:
        x_m, y_m = plant.position_of(place)
        centre = Place(x_m=x_m, y_m=y_m, reach_m=plant.diameter_m)
        super().__init__(place, centre, rules, life, assessor, subscriptions.arrivals)
        self._place, self._plant, self._keys = place, plant, keys
        self._stock, self._door = stock, door
        self.reliability = assessor.reliability
        self.sourcing = Sourcing(place, plant, self._open, self._closed, life)
        self.waits = CarrierWaits(place, assessor.handling_max_s, self._open)
        self._auctions.waits = self.announced_waits
        self._secondaries = Secondaries(self._open, self._auctions, subscriptions, life)
        self.failover = Failover(
            self._open,
            self._secondaries,
            subscriptions,
            life,
            self,
            assessor,
        )
        self.alarms |= self.sourcing.alarms | self._secondaries.alarms | self.failover.alarms

    def superseded(self, task_id: str, epoch: int) -> Superseded:
        """The answer to a vehicle that wrongly believes to carry a task in this epoch."""
        task, closed = self._open.get(task_id), self._closed.get(task_id)
        if task is not None:
            return Superseded(task=task_id, epoch=task.epoch)
        # No epoch of an ended or unknown task is valid any more.
        return Superseded(task=task_id, epoch=max(closed.epoch, epoch) if closed is not None else 0)

    # --- for the failover (`dray.protocol.takeover.failover.Remedies`) ---

    def is_missing(self, task: OpenTask) -> bool:
        """Whether the load of a task is gone from here, although no vehicle has fetched it."""
        work = cast(Transport, task.work)
        return task.lies_at_source and self._stock.lacks_goods(work.item, work.quantity)

    def source_answers(self, task: OpenTask, now_s: float) -> bool:
        """Whether the station that has the load of a task has answered lately."""
        return self.sourcing.answers(task, now_s)

    def reopen(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """Announce a task anew, with a higher epoch; its carrier is superseded.

        It is held if only a person can tell whether the carrier has put the load down.
        """
        if task.recovered:
            self.give_up(task, now_s)
        elif reason is Reason.FORGOTTEN and (load := self._perhaps_down(task)) is not None:
            self.hold(task, now_s, perhaps_down=load)
        else:
            self._replace(task, (), reason, now_s)

    def pass_on(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """Ask the secondary to carry a task, with a higher epoch; announce it if the secondary declines."""
        if task.recovered:
            self.give_up(task, now_s)
        else:
            self._replace(task, self._secondaries.standby_candidate(task), reason, now_s)

    def wait(self, task: OpenTask, trouble: Reason, now_s: float) -> None:
        """Let a task wait for its carrier, and report why."""
        task.trouble, task.detail = trouble, ""
        self._contracted(task, now_s)

    def hold(
        self,
        task: OpenTask,
        now_s: float,
        *,
        perhaps_down: DepartureMemory | None = None,
        fails_at: str = "",
    ) -> None:
        """Release the carrier of a task; no vehicle carries it before a person has looked.

        Its handover was disputed, unless one of the last two arguments is given.

        Args:
            task: the task.
            now_s: the present time.
            perhaps_down: the load that its carrier may have put down and has forgotten.
            fails_at: the place where its carriers have failed.
        """
        left = task.is_loaded
        self.failover.aboard.forget(task)
        why = (Reason.NOT_COUNTED, Reason.DISPUTED) if perhaps_down is None else (Reason.FORGOTTEN,) * 2
        if fails_at:
            why = (Reason.STALLED,) * 2
        replaced, silent_s = self._supersede(task, task.epoch + 1, why[0], now_s)
        task.states.enter(TaskState.HELD)
        task.left, task.perhaps_down, task.fails_at = left, perhaps_down, fails_at
        if fails_at:
            task.disputed_by = self._assessor.docks.accusers(fails_at, task.work_item)
        task.auction = self._auction(task.id, task.epoch, task.work, task.deadline_s)
        task.auction.cancel()
        self._life.cancel((PRIMARY_AUCTION, task.id))
        task.trouble = Reason.DISPUTED
        self.failover.note_change(task, replaced, why[1], silent_s)
        self._contracted(task, now_s)

    def resume(self, task: OpenTask, now_s: float) -> None:
        """A person has looked, and a held task's load is not at its destination: announce it anew.

        Goods that had left are made again.
        """
        if task.fails_at:
            self._assessor.docks.forget(task.fails_at, task.work_item)
        if task.recovered or task.left:
            self.give_up(task, now_s)
            return
        task.disputes, task.disputed_by, task.perhaps_down, task.fails_at = 0, (), None, ""
        task.clear_trouble()
        task.states.enter(TaskState.UNASSIGNED)
        deadline_s = max(prolonged_s(task.due_s, task.opened_s, now_s), now_s + task.auction.span_s)
        task.auction = self._auction(task.id, task.epoch, task.work, deadline_s)
        self._announce(task, now_s)
        self._contracted(task, now_s)

    def give_up(self, task: OpenTask, now_s: float) -> None:
        """End a task whose goods are lost, or of which nothing remains for another carrier."""
        self.close(task, "withdrawn")
        self._life.note(TaskLost(task))

    def conclude(self, task: OpenTask, _now_s: float) -> None:
        """Close a task as delivered: its load was counted, although no handover was received."""
        self.close(task, "delivered")
        self._life.note(TaskDelivered(task, "", cast(Transport, task.work).quantity))

    def conclude_for(self, task: OpenTask, carrier: str) -> None:
        """Close a task as delivered by an earlier carrier, and call the present one off."""
        self.sourcing.on_task_closed(task, fetched=False)
        if present := task.primary:
            self._let_go(task, Reason.TASK_ENDED)
            self._life.send(present, Withdrawn(task=task.id, epoch=task.epoch, reason=Reason.NOT_NEEDED))
        task.contract = CarrierContract(carrier)
        task.contract.receipt.booked = True
        self.close(task, "delivered")
        self._life.note(TaskDelivered(task, carrier, cast(Transport, task.work).quantity))

    def close(self, task: OpenTask, outcome: Outcome) -> None:
        """End a task; a delivered one is rated as kept or late."""
        if outcome == "delivered":
            self._assessor.docks.forget(cast(Transport, task.work).destination, task.work_item)
            self._assessor.docks.forget(task.fails_at, task.work_item)
        if outcome == "delivered" and task.contract.progress is not None:
            now_s, late_s = task.contract.progress.heard_s, task.contract.progress.late_s
            self.reliability.note_kept(task.primary, task.id, late_s, now_s)
        self.sourcing.on_task_closed(task, fetched=outcome == "delivered")
        super().close(task, outcome)

    # --- after a restart ---

    def restore(self, memory: TaskMemory, now_s: float) -> OpenTask:
        """Continue a task of an earlier life.

        A known primary is followed as before: its heartbeat soon shows whether it still carries the task. A task
        without one may have been accepted while the coordinator was down. It is announced after RECOVERY_WAIT_S,
        with a higher epoch, unless a vehicle has named it by then.
        """
        epoch = memory.epoch + 1 if memory.offered and not memory.primary else memory.epoch
        deadline_s = prolonged_s(memory.deadline_s, memory.opened_s, now_s)
        auction = self._auction(memory.task, epoch, memory.work, deadline_s)
        task = self._open[memory.task] = OpenTask(memory.task, memory.work, auction, memory.opened_s)
        task.due_s, task.witnessed, task.least_epoch = memory.deadline_s, False, memory.least_epoch
        task.recovered, task.disputes = memory.recovered, memory.disputes
        if memory.held:
            auction.cancel()
            task.states.enter(TaskState.HELD)
            task.left, task.trouble = memory.loaded, Reason.DISPUTED
            task.perhaps_down, task.fails_at = memory.perhaps_down, memory.fails_at
        elif memory.primary:
            auction.cancel()
            self._restore_carrier(task, memory, now_s)
        else:
            auction.open_later(now_s + RECOVERY_WAIT_S)
            self._auctions.arm(PRIMARY_AUCTION, auction)
        self.failover.aboard.restore(task, memory.stranded)
        return task

    def acknowledge_carrier(self, atv: str, brief: Brief, now_s: float) -> None:
        """Acknowledge the contract of a vehicle that names this coordinator after a restart, if it is possible."""
        task = self._open.get(brief.task)
        if task is not None and self._may_be_carried(task, brief.epoch):
            self._bind_carrier(task, atv, brief.epoch, brief.due_s or 0.0, now_s, brief.phase)

    def acknowledge_unknown(self, atv: str, brief: Brief, work: Work, now_s: float) -> None:
        """Acknowledge a vehicle's contract for a task without notes."""
        deadline_s = brief.due_s if brief.due_s is not None else now_s
        auction = self._auction(brief.task, brief.epoch, work, deadline_s)
        task = self._open[brief.task] = OpenTask(brief.task, work, auction, now_s)
        task.recovered, task.witnessed = True, False
        self._bind_carrier(task, atv, brief.epoch, deadline_s, now_s, brief.phase)

    # --- messages ---

    def on_bid(self, sender: str, bid: Bid, now_s: float) -> None:
        task = self._present(bid)
        if any(other.primary == sender for other in self):
            self._life.ignore("a bid of a vehicle that carries for this coordinator")
        elif task is not None and cast(Transport, task.work).vehicle not in ("", sender):
            self._life.ignore("a bid for a transport that only another vehicle may carry")
        elif task is not None and bid.role is Role.SECONDARY:
            self._secondaries.on_bid(task, sender, bid, now_s)
        else:
            super().on_bid(sender, bid, now_s)

    def on_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        task = self._open.get(answer.task)
        if answer.role is Role.PRIMARY and task is not None and self._may_be_carried(task, answer.epoch):
            # Only the vehicle has noted the award, and it was restarted too.
            self._bind_carrier(task, sender, answer.epoch, by_our_clock(answer, now_s).finish_s, now_s)
            return
        task = self._present(answer)
        if task is not None and answer.role is Role.SECONDARY:
            before = task.secondary
            self._secondaries.on_accepted(task, sender, answer, now_s)
            if task.secondary != before:
                self._life.commit()
        else:
            super().on_accepted(sender, answer, now_s)

    def on_declined(self, sender: str, answer: Declined, now_s: float) -> None:
        task = self._present(answer)
        if task is not None and answer.role is Role.SECONDARY:
            self._secondaries.on_declined(task, sender, answer, now_s)
        else:
            super().on_declined(sender, answer, now_s)

    def on_resigned(self, sender: str, message: Resigned, now_s: float) -> None:
        """A secondary resigns, or a primary gives its task back: seek another at once.

        A primary may repeat this until it hears that its contract is over.
        """
        task = self._open.get(message.task)
        if task is None or message.epoch != task.epoch:
            self._life.ignore("a resignation from a contract that has ended")
            if message.role is Role.PRIMARY:
                self._life.send(sender, self.superseded(message.task, message.epoch))
        elif message.role is Role.SECONDARY and sender == task.secondary:
            self._secondaries.lose(task, message.reason, now_s)
        elif message.role is Role.PRIMARY and sender == task.primary:
            self.failover.give_back(task, message.reason, now_s)
        else:
            self._life.ignore("a resignation from a contract that the sender does not have")

    def on_taken_over(self, sender: str, message: TakenOver, now_s: float) -> None:
        """A secondary has taken a task over, because its primary has failed."""
        task = self._open.get(message.task)
        if task is not None and task.primary == sender and task.epoch == message.epoch:
            self._confirm(task)
        elif task is not None and task.epoch == message.epoch and task.auction.asked == sender:
            # The messages have crossed: its takeover counts as its answer to the award.
            number, at_s = task.auction.number, message.at_s
            answer = Accepted(task.id, task.epoch, Role.PRIMARY, message.finish_s, number, at_s)
            self.on_accepted(sender, answer, now_s)
            self._life.settle(now_s)
            if task.primary == sender:
                self._confirm(task)
        elif task is None or message.epoch <= task.epoch:
            self._life.send(sender, self.superseded(message.task, message.epoch))
        elif objection := self.failover.objection(task, sender, message, now_s):
            self._release(sender, message, objection)
        elif self._assessor.refuses_clock(sender, message, now_s):
            self._release(sender, message, Reason.CLOCK_WRONG)
        else:
            self._change_carrier(task, sender, by_our_clock(message, now_s), now_s)

    def on_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note a contracted vehicle's heartbeat, and whether it names its contract."""
        for task in list(self._open.values()):
            if task.primary == heartbeat.atv:
                was_aboard = task.contract.phase in GOODS_ABOARD
                self.waits.note_phase(task, heartbeat, now_s)
                if task.contract.phase in GOODS_ABOARD and not was_aboard:
                    self._assessor.docks.forget(task.contract.source, task.work_item)
                self.failover.on_heartbeat(task, heartbeat, now_s)
                self._life.settle(now_s)
            elif task.secondary == heartbeat.atv:
                self._secondaries.on_heartbeat(task, heartbeat, now_s)

    def offer(self, atv: str, abilities: Collection[str], now_s: float) -> bool:
        """Offer the most urgent waiting transport to a vehicle that asks for work; False if there is none."""
        if any(task.primary == atv for task in self) or (task := most_urgent(self, atv, abilities)) is None:
            return False
        task.auction.offer(atv, now_s)
        return True

    def announced_waits(self, work: Work, now_s: float) -> tuple[Wait, ...]:
        """Known waits at the places of a transport."""
        return self.waits.told(cast(Transport, work), now_s)

    # --- internals ---

    def _audience(self, _work: Work, radius_m: float) -> tuple[str, ...]:
        x_m, y_m = self._plant.position_of(self._place)
        return tuple(self._keys.transports(cell) for cell in self._plant.cells_within(x_m, y_m, radius_m))

    def _contracted(self, task: OpenTask, now_s: float) -> None:
        """A task has a primary, another one, or none again; or it waits for its primary."""
        self._life.commit()
        self._life.beat_soon(now_s)
        if task.is_held:
            # Others may need the reserved material meanwhile.
            self.sourcing.on_task_closed(task, fetched=False)
        else:
            self.sourcing.follow(task, now_s)
        super()._contracted(task, now_s)

    def _wake_auction(self, task_id: str, now_s: float) -> None:
        task = self._open.get(task_id)
        was_offered = task is not None and task.is_offered
        if task is not None and task.auction.is_due(now_s) and stands_back(task, self):
            task.auction.stand_behind(now_s)
            self._auctions.arm(PRIMARY_AUCTION, task.auction)
        else:
            super()._wake_auction(task_id, now_s)
        if not was_offered:
            self._life.commit()  # A vehicle may accept from now on: another life must use a higher epoch.

    def _announce(self, task: OpenTask, now_s: float) -> None:
        asked = sum(other.auction.awaits_answers for other in self) if self.waits.docks else 0
        stands_behind = stands_back(task, self)
        if task.auction.has_candidates or not (asked or stands_behind):
            super()._announce(task, now_s)
            return
        if stands_behind:
            task.auction.stand_behind(now_s)
        else:  # Bidders must know the vehicles before them at docks, so vehicles are hired one by one.
            task.auction.open_later(now_s + asked * ONE_AFTER_ANOTHER_S, tell=True)
        self._auctions.arm(PRIMARY_AUCTION, task.auction)

    def _may_be_carried(self, task: OpenTask, epoch: int) -> bool:
        """Whether a vehicle may have accepted an earlier life's task in this epoch, and no other since.

        Once others were asked, or a carrier was told of an epoch, in any life, the epoch must not fall.
        """
        least = max(task.epoch - 1, task.least_epoch)
        is_free = not task.primary and not task.is_offered and not task.is_held
        return is_free and least <= epoch <= task.epoch

    def _bind_carrier(
        self,
        task: OpenTask,
        atv: str,
        epoch: int,
        promised_s: float,
        now_s: float,
        phase: Phase | None = None,
    ) -> None:
        task.auction.cancel()
        task.epoch = epoch
        self._life.cancel((PRIMARY_AUCTION, task.id))
        self._bind(task, atv, "", promised_s, now_s)
        task.contract.phase, task.contract.phase_s = phase, now_s
        self._contracted(task, now_s)

    def _restore_carrier(self, task: OpenTask, memory: TaskMemory, now_s: float) -> None:
        task.assign(CarrierContract(memory.primary, memory.source, memory.promised_s))
        if memory.loaded:
            task.states.enter(TaskState.IN_TRANSIT)
            # Goods from here were booked out when they left. People may have counted since: once more would be wrong.
            task.contract.receipt.booked = memory.work.destination != self._place
        task.contract.forgotten_aboard = memory.forgotten_aboard
        self.failover.follow(task, IDLE_INTERVAL_S, now_s)
        if memory.secondary:
            self._secondaries.restore(task, memory.secondary, memory.watch_number, now_s)
        else:
            self._secondaries.seek(task, (), now_s)

    def _bound(self, task: OpenTask, runners_up: tuple[tuple[str, Bid], ...], now_s: float) -> None:
        self.waits.foresee(task, now_s)
        self.failover.follow(task, WORKING_INTERVAL_S, now_s)
        self._secondaries.seek(task, runners_up, now_s)

    def _let_go(self, task: OpenTask, reason: Reason) -> None:
        self._secondaries.drop(task, reason)
        self.failover.leave(task)
        if task.primary:
            self._shut_door(task)
        task.contract = CarrierContract()

    def _shut_door(self, task: OpenTask) -> None:
        """The primary has lost the task: a transfer that it has begun ends without effect, if the dock can do that."""
        vehicle, work = task.primary, cast(Transport, task.work)
        if task.contract.receipt.booked or task.is_counted:
            self._door.close(vehicle, task.id)
            return
        change = work.quantity if work.destination == self._place else -work.quantity
        load = DepartureMemory(vehicle, task.id, task.epoch, work.item, change)
        self._door.shut(vehicle, task.id, load)

    def _perhaps_down(self, task: OpenTask) -> DepartureMemory | None:
        """The load that a carrier without memory may have put down here; None if that is known, or it has not come.

        An earlier life let the carrier in, and this body does not count. A carrier that remembers would have told
        by now (`vehicle.put_down`).
        """
        work, visits = cast(Transport, task.work), self._door.visits
        last = task.contract.detector.last if task.contract.detector is not None else None
        is_aboard = last is not None and last.load == work.item
        if visits.counts or work.destination != self._place or task.contract.receipt.booked or is_aboard:
            return None
        if not visits.is_of_earlier_life(task.primary):
            return None
        return DepartureMemory(task.primary, task.id, task.epoch, work.item, work.quantity)

    def _bind(self, task: OpenTask, atv: str, source: str, promised_s: float, now_s: float) -> None:
        """Bind a vehicle to a task without an auction of this life."""
        if task.witnessed:
            promised_s = self._assessor.believed_s(task.work, None, promised_s, now_s)
        task.assign(CarrierContract(atv, source, promised_s, now_s))
        self._bound(task, (), now_s)

    def _change_carrier(self, task: OpenTask, atv: str, message: TakenOver, now_s: float) -> None:
        detector = task.contract.detector
        failure = detector.failure(now_s) if detector is not None else None
        self.failover.blame(task, failure or message.reason, now_s)
        if task.secondary == atv:
            self._secondaries.unfollow(task)
        replaced, silent_s = self._supersede(task, message.epoch, Reason.ANOTHER_TOOK_OVER, now_s)
        self._bind(task, atv, message.source, message.finish_s, now_s)
        self._confirm(task)
        self.failover.note_change(task, replaced, failure or message.reason, silent_s)
        self._contracted(task, now_s)

    def _replace(
        self, task: OpenTask, candidates: tuple[tuple[str, Bid], ...], reason: Reason, now_s: float
    ) -> None:
        replaced, silent_s = self._supersede(task, task.epoch + 1, reason, now_s)
        task.states.enter(TaskState.UNASSIGNED)
        # A new carrier may need as much time as the earlier rounds had reached.
        deadline_s = max(prolonged_s(task.due_s, task.opened_s, now_s), now_s + task.auction.span_s)
        task.auction = self._auction(task.id, task.epoch, task.work, deadline_s, candidates)
        self.failover.note_change(task, replaced, reason, silent_s)
        self._announce(task, now_s)
        self._contracted(task, now_s)

    def _supersede(self, task: OpenTask, epoch: int, reason: Reason, now_s: float) -> tuple[str, float]:
        """Fence off the present carrier. Returns its id, and how long it has been silent (s)."""
        replaced, silent_s = task.primary, self.failover.silent_s(task, now_s)
        self._let_go(task, reason)
        task.epoch = task.least_epoch = epoch
        self._life.send(replaced, Superseded(task=task.id, epoch=epoch))
        return replaced, silent_s

    def _confirm(self, task: OpenTask) -> None:
        self._life.send(task.primary, Confirmed(task=task.id, epoch=task.epoch))
