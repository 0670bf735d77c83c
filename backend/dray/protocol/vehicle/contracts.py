"""One vehicle's transports: announced ones, the one that it carries, and those that it watches (paper, 4.1).

It carries at most one (invariant 3), and watches others only while it has none. The vehicle reacts to the end of each
(`WorkEnded`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, cast

from msgspec.structs import replace

from dray.memory import Contract
from dray.messages import (
    THING,
    AtvHeartbeat,
    Award,
    Confirmed,
    DockHeld,
    DockOpened,
    HandoverAccepted,
    Message,
    Phase,
    Reason,
    Release,
    Role,
    Superseded,
    TakenOver,
    TaskAnnounced,
    Transport,
    Withdrawn,
)
from dray.messages.fact import ContractEnded, ContractTaken, TookOver
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.parties import NO_PARTY
from dray.protocol.contract_net.replies import accept, decline
from dray.protocol.contract_net.trust.probation import Probation
from dray.protocol.contract_net.waits import Waits
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Effect, Record
from dray.protocol.runtime.life import Change, Life
from dray.protocol.takeover.standby import WATCHED_SILENCE, Standby
from dray.protocol.vehicle.bidding import Bidder, Standing
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.job.job_messages import ASK, CLAIM_TASK
from dray.protocol.vehicle.job.job_moves import RETRY
from dray.protocol.vehicle.job.transport_job import TransportJob
from dray.protocol.vehicle.pricing import Quote, Unable
from dray.protocol.vehicle.put_down import PutDown
from dray.protocol.vehicle.work_search import ASK_FOR_WORK, SEEK, WorkSearch


@dataclass(frozen=True, slots=True)
class WorkEnded(Change):
    """The vehicle has no transport any more.

    Attributes:
        reason: why its contract has ended.
    """

    reason: Reason


class Owner(Protocol):
    """The vehicle, as its contracts need it."""

    battery_frac: float
    battery_reckoned: bool
    load: tuple[str, int]
    """The item on board and its quantity; empty and 0 for none."""

    @property
    def gives_back(self) -> Reason | None:
        """Why it gives back a task whose load is not on board; None if it does not."""

    def is_reserve(self, now_s: float) -> bool:
        """Whether it belongs to the reserve of a fleet that is too large for the roads."""

    def unfit(self) -> str:
        """Why it may take no work at all; empty if it may."""

    def stop_resting(self, now_s: float) -> None:
        """Leave the charger or parking place for work."""

    def update_status(self, now_s: float, reason: str) -> None:
        """Update the status, and report the reason if it has changed."""


class Contracts:
    """The contracts of one vehicle.

    Args:
        atv: the vehicle's id.
        plant: the plant it works in.
        vehicle_type: id of its type.
        probation: transports to do well before it takes long ones.
        driver: the vehicle's place on the lanes.
        charging: the vehicle's charging.
        owner: the vehicle.

    Attributes:
        job: the transport that it carries; None without one.
        standby: its watches.
        put_down: loads that it has put down, and of which it still tells.
        probation: its progress on probation.
        subscriptions: its heartbeat subscriptions.
        message_handlers: by message type, handlers called with (sender, message, now_s).
        alarms: handlers of these alarms.
    """

    def __init__(
        self,
        atv: str,
        plant: Plant,
        vehicle_type: str,
        probation: int,
        driver: Driver,
        charging: Charging,
        life: Life,
        owner: Owner,
    ) -> None:
        self._atv = atv
        self._plant = plant
        self._type = vehicle_type
        self._driver = driver
        self._charging = charging
        self.probation = Probation(probation)
        self._life = life
        self._owner = owner
        keys = Keys(plant.id)
        self._waits = Waits()
        self._bidder = Bidder(atv, plant, vehicle_type, self.probation, charging, self._waits, life)
        self._work_search = WorkSearch(atv, plant, vehicle_type, keys, life)
        self._phase_s: float | None = None
        """Begin of its job's present phase (plant clock); None if an earlier life began it."""
        self.job: TransportJob | None = None
        self.subscriptions = HeartbeatSubscriptions(keys.atv_heartbeat, life)
        self.standby = Standby(self.subscriptions, life)
        self.put_down = PutDown(life)
        contract = self._on_of_contract
        self.message_handlers: Mapping[type[Message], Callable[..., None]] = {
            AtvHeartbeat: lambda _sender, message, now_s: self.standby.on_heartbeat(message, now_s),
            TaskAnnounced: self._on_announced,
            Award: self._on_award,
            Release: self._on_release,
            DockOpened: self._on_of_dock,
            DockHeld: self._on_of_dock,
            HandoverAccepted: contract,
            Confirmed: contract,
            Superseded: contract,
            Withdrawn: contract,
        }
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {
            ASK: self._wake_job,
            RETRY: self._wake_job,
            CLAIM_TASK: self._claim_again,
            WATCHED_SILENCE: self._look_after,
            ASK_FOR_WORK: self._ask_for_work,
            SEEK: self._seek_on,
            **self.put_down.alarms,
        }

    def bring_back(self, now_s: float) -> None:
        """A load without a contract comes from an earlier life: bring it back without a coordinator."""
        load, quantity = self._owner.load
        if self.job is not None or not load:
            return
        plant = self._plant
        refuges = plant.storages_of(load) if load in plant.materials else tuple(plant.delivery_warehouses)
        if load == THING:
            # Its origin is unknown: people find it at a storage.
            refuges = tuple(plant.stores)
        work = Transport(item=load, quantity=quantity, sources=refuges, destination=refuges[0], ability="")
        # A unique id each: loads brought back under one id are booked in once.
        task, why = f"{self._atv}-found-{now_s:.0f}", Reason.LOAD_UNKNOWN
        contract = Contract(task, 0, work, self._atv, refuges[0], 0.0, 0.0, cancelled=why)
        self.standby.resign(Reason.HAS_WORK)
        self._owner.stop_resting(now_s)
        self.bind(contract)
        self.go_on(lambda job: job.resume(load, now_s), now_s)

    def check_load(self, now_s: float) -> None:
        """The load of a void contract may be gone: its body has unloaded to the end for an earlier life."""
        if self.job is not None and self.job.misses_load(self._owner.load[0]):
            self._wake_job(None, now_s)

    def _standing(self, task: str, now_s: float) -> Standing:
        """The vehicle's state for considering `task`."""
        driver = self._driver
        x_m, y_m = driver.position_m
        return Standing(
            node=driver.next_node,
            node_at_s=driver.next_node_at_s(now_s),
            node_in_m=driver.next_node_in_m,
            x_m=x_m,
            y_m=y_m,
            speed_frac=driver.pace_frac,
            battery_frac=self._owner.battery_frac,
            battery_reckoned=self._owner.battery_reckoned,
            unfit=self._owner.unfit(),
            busy_with=self.job.task if self.job is not None else "",
            watches=len(self.standby) - (task in self.standby),
            is_reserve=self._owner.is_reserve(now_s),
        )

    def _on_announced(self, _sender: str, message: TaskAnnounced, now_s: float) -> None:
        if not self._work_search.take(message, now_s):
            self._answer_announced(message, now_s)

    def _answer_announced(self, message: TaskAnnounced, now_s: float) -> bool:
        """Bid or refuse; False for a refusal."""
        # It may watch the task already: the coordinator has forgotten that.
        reason = self._bidder.on_announced(message, self._standing(message.task, now_s), now_s)
        if reason is not None:
            self._work_search.note_refused(message, reason, self._owner.battery_frac)
        return reason is None

    def seek(self, now_s: float) -> None:
        """Ask for waiting work if it can take any."""
        may_work = not (self._charging.is_needy or self._owner.is_reserve(now_s) or self._owner.unfit())
        if self._work_search.is_known and may_work:
            self._work_search.ask_for_work(self._owner.battery_frac, now_s)

    def _ask_for_work(self, _about: str, now_s: float) -> None:
        if self._may_seek():
            self._work_search.ask_again(now_s)

    def _may_seek(self) -> bool:
        if self.job is None and not self._owner.unfit():
            return True
        self._work_search.stop()
        return False

    def _seek_on(self, _about: None, now_s: float) -> None:
        if not self._may_seek():
            return
        while (message := self._work_search.choose(now_s)) is not None:
            if self._answer_announced(message, now_s):
                return

    def _on_award(self, sender: str, award: Award, now_s: float) -> None:
        if self._holds(award):
            # Its answer was lost. From now on this award binds.
            self._renew(award)
            self._life.do(accept(sender, award, self._promised_s, now_s))
            return
        answer = self._bidder.review(award, self._standing(award.task, now_s), now_s)
        if isinstance(answer, Unable):
            self._life.do(decline(sender, award, answer.reason))
        elif award.role is Role.SECONDARY:
            self.standby.watch(award, sender, now_s)
            self._life.do(accept(sender, award, self._promised_s, now_s))
            self._life.beat_soon(now_s)
        else:
            contract = _contract(award, sender, answer)
            accepted = accept(sender, award, contract.promised_s, now_s)
            self._take(contract, accepted, lambda job: job.set_off(now_s), now_s)

    def _holds(self, award: Award) -> bool:
        """Whether it has accepted this award already."""
        if award.role is Role.SECONDARY:
            return self.standby.holds(award.task, award.epoch)
        job = self.job
        return job is not None and not job.is_void and (job.task, job.epoch) == (award.task, award.epoch)

    def _renew(self, award: Award) -> None:
        if award.role is Role.SECONDARY:
            self.standby.renew(award)
        elif self.job is not None:
            self.job.number = award.number
            self._life.commit()

    @property
    def _promised_s(self) -> float:
        """Promised finish of its task (plant clock); 0 without one."""
        return self.job.promised_s if self.job is not None else 0.0

    def _look_after(self, task: str, now_s: float) -> None:
        """A primary may have failed: take its task over if possible."""
        watch = self.standby.failed(task, now_s)
        if watch is None:
            return
        award = watch.award
        quote = self._bidder.quote(award.work, self._standing(task, now_s), now_s)
        if isinstance(quote, Unable):
            self.standby.resign_from(task, Reason.UNABLE, quote.detail or quote.reason.value)
            return
        epoch, reason = award.epoch + 1, cast(Reason, watch.detector.failure(now_s))
        silent_s = now_s - watch.detector.heard_s
        took = TookOver(task=task, epoch=epoch, primary=award.primary, silent_s=silent_s, reason=reason)
        claim = TakenOver(
            task=task,
            epoch=epoch,
            primary=award.primary,
            reason=reason,
            finish_s=quote.finish_s,
            source=quote.source,
        )
        self.standby.unwatch(task, Reason.TAKEN_OVER)
        contract = replace(_contract(award, watch.coordinator, quote), epoch=epoch, number=0, claim=claim)
        self._take(contract, Record(took), lambda job: job.take_over(now_s), now_s)

    def _take(
        self, contract: Contract, how: Effect, begin: Callable[[TransportJob], None], now_s: float
    ) -> None:
        """Become the primary of a task, and end all watches and rest.

        Args:
            contract: the contract of the task.
            how: the effect to do first: the acceptance or the takeover.
            begin: the job's first step.
            now_s: the present time.
        """
        self.bind(contract)
        taken = ContractTaken(
            task=contract.task, epoch=contract.epoch, role=Role.PRIMARY, coordinator=contract.coordinator
        )
        self._life.do(how, Record(taken))
        self.standby.resign(Reason.HAS_WORK)
        self._owner.stop_resting(now_s)
        self._work_search.stop()
        self._owner.update_status(now_s, contract.task)
        self.go_on(begin, now_s)

    def bind(self, contract: Contract) -> None:
        self.put_down.forget(contract.task)
        self._phase_s = None
        self.job = TransportJob(contract, self._plant, self._type, self._driver, self._life)
        self._life.commit()

    def _on_release(self, _sender: str, message: Release, now_s: float) -> None:
        if message.role is Role.SECONDARY:
            if not self.standby.release(message):
                self._life.ignore("a release from a watch that the vehicle does not keep")
            return
        job = self.job
        if job is None or not job.is_meant_by(message) or message.number != job.number:
            self._life.ignore("a release from a contract that the vehicle does not have")
            return
        self.go_on(lambda job: job.cancel(Reason.RELEASED, now_s), now_s)

    def _on_of_contract(self, _sender: str, message: Any, now_s: float) -> None:
        job = self.job
        if job is None or not job.is_meant_by(message):
            is_of_load = isinstance(message, HandoverAccepted | Superseded | Withdrawn)
            if not (is_of_load and self.put_down.on_answer(message)):
                self._life.ignore("a message about another contract")
            return
        self.go_on(lambda job: job.on_answer(message, now_s), now_s)

    def _on_of_dock(self, sender: str, message: DockOpened | DockHeld, now_s: float) -> None:
        if sender == (message.station if self.job is None else self.job.answers_at(message.station)):
            self._on_of_contract(sender, message, now_s)
        else:
            self._life.ignore(NO_PARTY)

    def coordinator_of(self, task: str, role: Role) -> str:
        """The coordinator of its contract for this task and role; empty without one."""
        if role is Role.SECONDARY:
            return self.standby.coordinator_of(task)
        job = self.job
        return job.coordinator if job is not None and job.task == task else self.put_down.coordinator_of(task)

    def _wake_job(self, _about: str | None, now_s: float) -> None:
        self.go_on(lambda job: job.wake(self._owner.load[0], now_s), now_s)

    def _claim_again(self, _about: None, now_s: float) -> None:
        if self.job is not None:
            self.job.claim_again(now_s)

    def go_on(self, step: Callable[[TransportJob], None], now_s: float) -> None:
        """Let the job take a step, if there is one, and handle the changes."""
        job = self.job
        if job is None:
            return
        phase, memory = job.phase, job.memory()
        step(job)
        if job.phase is not phase:
            self._note_wait(job, phase, now_s)
        if (why := self._owner.gives_back) is not None:
            job.give_back(why, now_s)
        self._life.beat_soon(now_s)
        if job.ended:
            self._end_job(job, now_s)
        elif job.memory() != memory:
            self._life.commit()

    def _note_wait(self, job: TransportJob, phase: Phase, now_s: float) -> None:
        """A phase of the job is over: note its waiting time if this life has seen its beginning."""
        began_s, self._phase_s = self._phase_s, now_s
        if began_s is None:
            return
        kind, took_s = self._plant.vehicle_types[self._type], now_s - began_s
        if phase is Phase.LOADING and job.phase is Phase.CARRYING:
            self._waits.note(job.source, "", took_s - kind.load_s, now_s)
        elif phase is Phase.UNLOADING and job.phase is Phase.HANDING_OVER:
            self._waits.note(job.work.destination, "", took_s - kind.unload_s, now_s)

    def _end_job(self, job: TransportJob, now_s: float) -> None:
        reason = cast(Reason, job.ended)
        ended = ContractEnded(
            task=job.task, epoch=job.epoch, role=Role.PRIMARY, reason=reason, detail=job.detail
        )
        self._life.record(ended)
        self.job = None
        if job.is_untold and job.coordinator != self._atv:
            self.put_down.add(job.memory(), now_s)
        self._life.commit()
        if reason is Reason.HANDED_OVER:
            self.probation.note_done()
        self._life.note(WorkEnded(reason))
        self._life.settle(now_s)
        self.seek(now_s)


def _contract(award: Award, coordinator: str, quote: Quote) -> Contract:
    return Contract(
        task=award.task,
        epoch=award.epoch,
        work=cast(Transport, award.work),
        coordinator=coordinator,
        source=quote.source,
        promised_s=quote.finish_s,
        deadline_s=award.deadline_s,
        number=award.number,
    )
