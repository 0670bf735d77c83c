"""An autonomous transport vehicle: bids, carries, watches, charges itself (paper, 3.2).

The state machine of the paper, as everybody sees it:

    IDLE     bids for whatever is announced near by; parks out of the way
    CHARGING bids too, as far as its battery keeps what it promises
    WORKING  primary of one task (invariant 3), and of nothing else
    STOPPED  held by an operator: moves again only after an acknowledge and a resume (invariant 5)
    ERROR    something keeps it from going on

STOPPED and ERROR end no contract: the job waits inside them and goes on when they are over. How long
it can wait is in the heartbeat (`assistance`); after that another vehicle takes the task, and this one hears
so when it speaks again. A vehicle that is left with its radio keeps its task too, and takes nothing else.

One that is asked to leave gives its watches back, and its task too while the load is not on board; with a load
it leaves after the handover. Where it cannot move it leaves as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from msgspec.structs import replace

from dray.body import (
    ActionDone,
    ActionFailed,
    BodyState,
    LinkNoticed,
    NodePassed,
    ProblemCleared,
    ProblemRaised,
    VehicleState,
    WayDone,
)
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, AtvMemory, Contract, Memory, Note
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Award,
    CommandKind,
    Confirmed,
    Disbelieved,
    DockHeld,
    DockOpened,
    DwellPointClaimed,
    HandoverAccepted,
    Link,
    Message,
    Phase,
    Release,
    Role,
    Superseded,
    TakenOver,
    TaskAnnounced,
    Transport,
    VehicleCommand,
    Withdrawn,
)
from dray.messages.fact import (
    HANDED_OVER,
    AtvStatusChanged,
    ContractEnded,
    ContractTaken,
    LinkChanged,
    TookOver,
)
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.disbelief import Reproach
from dray.protocol.contract_net.parties import NO_PARTY, objection
from dray.protocol.contract_net.probation import Probation
from dray.protocol.contract_net.replies import accept, decline
from dray.protocol.contract_net.waits import Waits
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import interval_s
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import (
    Effect,
    Ignore,
    Publish,
    Record,
)
from dray.protocol.runtime.heartbeat_timer import BEAT, HeartbeatTimer
from dray.protocol.runtime.shutdown import CARRIER_LEAVES_WITHIN_S, GRACEFUL_SHUTDOWN
from dray.protocol.takeover.standby import WATCHED_SILENCE, Standby
from dray.protocol.vehicle.assistance import Assistance
from dray.protocol.vehicle.bidding import Bidder, Standing
from dray.protocol.vehicle.cell_subscription import CellSubscription
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.command_authorisation import CommandAuthorisation, Trusts, trusts_nobody
from dray.protocol.vehicle.command_handling import CommandHandling
from dray.protocol.vehicle.driving import Driver
from dray.protocol.vehicle.idle_positioning import CLAIM, SETTLE, IdlePositioning
from dray.protocol.vehicle.pricing import Quote, Unable
from dray.protocol.vehicle.transport_job import ASK, CLAIM_TASK, TransportJob
from dray.protocol.vehicle.work_search import SEEK, WorkSearch

ORDERS_PER_LIFE = 1_000_000
"""Numbers of ways and actions: what the body still reports to an earlier life is recognised."""


class Atv(AgentBase):
    """One vehicle.

    Args:
        atv: its id in the plant's fleet.
        plant: the plant it works in.
        vehicle_type: id of its type; by default that of the fleet's entry.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        probation: transports that it has to do well before it takes long ones; 0 for an agent that is known to be good.
        trusts: whose grants count when people command it.
    """

    def __init__(
        self,
        atv: str,
        plant: Plant,
        *,
        vehicle_type: str = "",
        incarnation: int = 1,
        software: str = "",
        probation: int = 0,
        trusts: Trusts = trusts_nobody,
    ) -> None:
        super().__init__(atv, incarnation, leaves_within_s=CARRIER_LEAVES_WITHIN_S)
        self._plant = plant
        self._type = vehicle_type or plant.fleet[atv].type
        self._software = software
        self._heartbeat_timer = HeartbeatTimer(self.id, self._timers)
        self._keys = Keys(plant.id)
        self._beat_key = self._keys.atv_heartbeat(atv)
        self._driver = Driver(plant, self._type, self._out, first_order=incarnation * ORDERS_PER_LIFE)
        self._cells = CellSubscription(plant, self._keys, self._out)
        self._subscriptions = HeartbeatSubscriptions(self._keys.atv_heartbeat, self._out)
        self._standby = Standby(self._subscriptions, self._timers, self._out)
        self._probation = Probation(probation)
        self._charging = Charging(plant, self._type)
        self._waits = Waits()
        self._bidder = Bidder(atv, plant, self._type, self._probation, self._charging, self._waits, self._out)
        self._phase_s = 0.0
        """Since when its job has been in its present phase (plant clock)."""
        self._idle = IdlePositioning(
            atv, plant, self._type, self._keys, self._charging, self._driver, self._timers, self._out
        )
        self._work_search = WorkSearch(atv, plant, self._type, self._keys, self._timers, self._out)
        self._assistance = Assistance(self._out)
        self._commands = CommandHandling(
            CommandAuthorisation(atv, plant, trusts), self._assistance, self._driver, self._out
        )
        self._job: TransportJob | None = None
        self._link = Link.WLAN
        self._status = AtvStatus.IDLE
        self._battery_frac = 1.0
        self._load = ("", 0)
        contract = self._on_of_contract
        self._message_handlers = {
            AtvHeartbeat: lambda _sender, message, now_s: self._standby.on_heartbeat(message, now_s),
            TaskAnnounced: self._on_announced,
            Award: self._on_award,
            Release: self._on_release,
            DockOpened: self._on_of_dock,
            DockHeld: self._on_of_dock,
            HandoverAccepted: contract,
            Confirmed: contract,
            Superseded: contract,
            Withdrawn: contract,
            VehicleCommand: self._on_command,
            DwellPointClaimed: self._on_claim,
            Disbelieved: Reproach(self._out).on_disbelieved,
        }
        self._report_handlers = {
            NodePassed: self._node_passed,
            WayDone: self._way_done,
            ActionDone: self._action_done,
            ActionFailed: self._action_failed,
            ProblemRaised: self._problem_raised,
            ProblemCleared: self._problem_cleared,
            LinkNoticed: self._link_noticed,
        }
        self._alarm_handlers = {
            BEAT: self._beat,
            ASK: self._ask_again,
            SETTLE: lambda _about, now_s: self._rest_on(SETTLE, now_s),
            CLAIM: lambda _about, now_s: self._rest_on(CLAIM, now_s),
            CLAIM_TASK: self._claim_again,
            WATCHED_SILENCE: self._look_after,
            SEEK: self._seek_on,
        }

    # --- the beginning, and time passing ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        self._sense(body, now_s)
        self._cells.move(*self._driver.position_m)
        state = cast(VehicleState, body)
        self._driver.take_control(state, now_s)
        self._assistance.problem, self._link = state.problem, state.link
        self._commands.stopped = state.held
        note = memory.get(WHOLE)
        if isinstance(note, AtvMemory):
            self._commands.recall(note)
        if isinstance(note, AtvMemory) and note.contract is not None:
            self._bind(note.contract)
            self._go_on(lambda job: job.resume(state.load, now_s), now_s)
        self._bring_back(now_s)
        self._charging.note(self._battery_frac, self._driver.next_node)
        if self._job is None:
            self._idle.start(self._battery_frac, now_s)
        self._update_status(now_s, "started")
        self._heartbeat_timer.at_once(now_s)

    def _bring_back(self, now_s: float) -> None:
        """A load without a contract is one of an earlier life: bring it back, for nobody."""
        load, quantity = self._load
        if self._job is not None or not load:
            return
        plant = self._plant
        refuges = plant.storages_of(load) if load in plant.materials else tuple(plant.delivery_warehouses)
        work = Transport(item=load, quantity=quantity, sources=refuges, destination=refuges[0], ability="")
        contract = Contract(
            task=f"{self.id}-found",
            epoch=0,
            work=work,
            coordinator=self.id,
            source=refuges[0],
            promised_s=0.0,
            deadline_s=0.0,
            cancelled="nobody knows of this load",
        )
        self._standby.resign("has a load to bring back")
        self._idle.stop()
        self._bind(contract)
        self._go_on(lambda job: job.resume(load, now_s), now_s)

    def _memory(self) -> Note:
        job = self._job
        return AtvMemory(
            contract=job.memory() if job is not None else None,
            acknowledged=self._commands.acknowledged,
            speed_frac=self._driver.speed_frac,
            answered=self._commands.answered,
        )

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        if not isinstance(body, VehicleState):
            raise ProtocolViolation(f"{self.id}: a vehicle needs a vehicle's body, not {body!r}")
        self._driver.sense(body)
        self._battery_frac = body.battery_frac
        self._load = (body.load, body.load_quantity)

    def _beat(self, _about: None, now_s: float) -> None:
        self._bring_back(now_s)
        self._heartbeat_timer.go_on(interval_s(self._say_status(now_s)), now_s)
        self._charging.note(self._battery_frac, self._driver.next_node)
        if self._job is None:
            self._idle.check_battery(self._battery_frac, now_s)
            self._seek(now_s)

    def _say_status(self, now_s: float) -> AtvHeartbeat:
        load, load_quantity = self._load
        job = self._job
        heartbeat = AtvHeartbeat(
            atv=self.id,
            incarnation=self.incarnation,
            seq=self._heartbeat_timer.count(),
            at_s=now_s,
            status=self._status,
            pose=self._driver.pose,
            node=self._driver.node,
            speed_mps=self._driver.speed_mps,
            battery_frac=self._battery_frac,
            load=load,
            load_quantity=load_quantity,
            task=job.brief() if job is not None else None,
            watches=self._standby.briefs() if self._standby else (),
            way=self._driver.ahead,
            dwell_point=self._idle.dwell_point,
            speed_limit_frac=self._driver.speed_frac,
            acknowledged=self._commands.acknowledged,
            link=self._link,
            problem=self._assistance.problem,
            help=self._assistance.help,
            software=self._software,
            draining=self._shutdown.begun,
            probation=self._probation.brief(),
        )
        self._out.append(Publish(self._beat_key, heartbeat))
        return heartbeat

    def _was_deaf(self, span_s: float) -> None:
        self._subscriptions.arrivals.deaf_s += span_s

    # --- the end ---

    def _prepare_to_leave(self, now_s: float) -> None:
        self._standby.resign(GRACEFUL_SHUTDOWN)
        if self._job is None:
            self._idle.stay(now_s)
        else:
            self._job.give_back(GRACEFUL_SHUTDOWN, now_s)
        self._heartbeat_timer.at_once(now_s)

    def _is_held(self) -> bool:
        if self._job is not None and self._job.is_given_back:
            return True
        if self._is_stuck:
            return False
        return self._job is not None or bool(self._driver.way)

    def _take_leave(self, now_s: float) -> None:
        self._say_status(now_s)

    # --- the body reports ---

    def _node_passed(self, report: NodePassed, _now_s: float) -> None:
        self._driver.on_passed(report)
        self._battery_frac = report.battery_frac
        self._cells.move(*self._driver.position_m)

    def _way_done(self, report: WayDone, now_s: float) -> None:
        if not self._driver.on_done(report):
            return
        if self._job is not None:
            self._go_on(lambda job: job.arrived(now_s), now_s)
        else:
            self._idle.arrived()
            self._update_status(now_s, self._idle.dwell_point)
        self._heartbeat_timer.at_once(now_s)

    def _action_done(self, report: ActionDone, now_s: float) -> None:
        if self._idle.action_done(report.order, now_s):
            self._update_status(now_s, "charged")
        else:
            self._go_on(lambda job: job.action_done(report.order, now_s), now_s)

    def _action_failed(self, report: ActionFailed, now_s: float) -> None:
        if self._idle.action_failed(report.order, now_s):
            self._update_status(now_s, report.reason)
        elif self._driver.on_failed(report):
            if self._job is not None:
                self._job.way_refused(now_s)
            else:
                self._idle.soon(now_s)
        else:
            self._go_on(lambda job: job.action_failed(report.order, report.reason, now_s), now_s)

    def _problem_raised(self, report: ProblemRaised, now_s: float) -> None:
        self._assistance.problem = report.reason
        if self._commands.take_back():
            self._commit()
        self._ask_for_help(report.reason, now_s)
        self._standby.resign("in error")
        self._update_status(now_s, report.reason)
        self._heartbeat_timer.at_once(now_s)

    def _problem_cleared(self, _report: ProblemCleared, now_s: float) -> None:
        self._assistance.problem = ""
        self._end_trouble(now_s)
        self._update_status(now_s, "problem cleared")

    def _ask_for_help(self, reason: str, now_s: float) -> None:
        job = self._job
        if job is not None:
            self._assistance.ask(reason, job.task, job.slack_s, now_s)

    def _end_trouble(self, now_s: float) -> None:
        """One reason to stand is gone; it goes on when no other is left."""
        if self._is_stuck:
            return
        self._assistance.over()
        if self._job is None:
            self._idle.soon(now_s)

    def _link_noticed(self, report: LinkNoticed, now_s: float) -> None:
        if report.link is self._link:
            return
        self._link = report.link
        self._out.append(Record(LinkChanged(link=report.link)))
        if report.link is Link.MESH:
            self._standby.resign("on the radio mesh")
        self._heartbeat_timer.at_once(now_s)

    # --- contracts ---

    def _standing(self, task: str, now_s: float) -> Standing:
        """The circumstances in which `task` is considered."""
        driver = self._driver
        x_m, y_m = driver.position_m
        return Standing(
            node=driver.next_node,
            node_at_s=driver.next_node_at_s(now_s),
            x_m=x_m,
            y_m=y_m,
            speed_frac=driver.speed_frac,
            battery_frac=self._battery_frac,
            unfit=self._unfit(),
            busy_with=self._job.task if self._job is not None else "",
            watches=len(self._standby) - (task in self._standby),
        )

    def _unfit(self) -> str:
        """Why it may take no work at all; empty when it may."""
        if self._assistance.problem:
            return self._assistance.problem
        if self._commands.stopped:
            return "stopped by an operator"
        if self._link is Link.MESH:
            return "on the radio mesh"
        if self._shutdown.begun:
            return GRACEFUL_SHUTDOWN
        return "a load is on board" if self._job is None and self._load[0] else ""

    def _on_announced(self, _sender: str, message: TaskAnnounced, now_s: float) -> None:
        if not self._work_search.take(message, now_s):
            self._answer_announced(message, now_s)

    def _answer_announced(self, message: TaskAnnounced, now_s: float) -> bool:
        """Bid, or not; False when the task is refused."""
        # Also for a task that it watches already: its coordinator does not know that any more.
        reason = self._bidder.on_announced(message, self._standing(message.task, now_s), now_s)
        if reason is not None:
            self._work_search.note_refused(message, reason, self._battery_frac)
        return reason is None

    def _seek(self, now_s: float) -> None:
        """Ask for work that waits, if it can take any."""
        if self._job is None and not self._unfit() and not self._charging.is_needy:
            self._work_search.begin(self._battery_frac, now_s)

    def _seek_on(self, _about: None, now_s: float) -> None:
        if self._job is not None or self._unfit():
            self._work_search.stop()
            return
        while (message := self._work_search.choose(now_s)) is not None:
            if self._answer_announced(message, now_s):
                return

    def _on_award(self, sender: str, award: Award, now_s: float) -> None:
        if self._holds(award):
            # Its answer was lost. From now on this award is the one that binds.
            self._renew(award)
            self._out.append(accept(sender, award, self._promised_s, now_s))
            return
        answer = self._bidder.review(award, self._standing(award.task, now_s), now_s)
        if isinstance(answer, Unable):
            self._out.append(decline(sender, award, answer.reason))
        elif award.role is Role.SECONDARY:
            self._standby.begin(award, sender, now_s)
            self._out.append(accept(sender, award, self._promised_s, now_s))
            self._heartbeat_timer.at_once(now_s)
        else:
            contract = _contract(award, sender, answer)
            accepted = accept(sender, award, contract.promised_s, now_s)
            self._take(contract, accepted, lambda job: job.begin(now_s), now_s)

    def _holds(self, award: Award) -> bool:
        """Whether it took this award already."""
        if award.role is Role.SECONDARY:
            return self._standby.holds(award.task, award.epoch)
        return self._has_contract(award.task, award.epoch)

    def _renew(self, award: Award) -> None:
        if award.role is Role.SECONDARY:
            self._standby.renew(award)
        elif self._job is not None:
            self._job.number = award.number
            self._commit()

    @property
    def _promised_s(self) -> float:
        """When it has promised to be done with its task (plant clock); 0 without one."""
        return self._job.promised_s if self._job is not None else 0.0

    def _look_after(self, task: str, now_s: float) -> None:
        """A primary may have failed: take its task over, if this vehicle can."""
        watch = self._standby.failed(task, now_s)
        if watch is None:
            return
        award = watch.award
        quote = self._bidder.quote(award.work, self._standing(task, now_s), now_s)
        if isinstance(quote, Unable):
            self._standby.resign_from(task, quote.detail or quote.reason.value)
            return
        epoch, reason = award.epoch + 1, watch.detector.failure(now_s)
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
        self._standby.end(task, "taken over")
        contract = _contract(award, watch.coordinator, quote)
        contract = replace(contract, epoch=epoch, number=0, claim=claim)
        self._take(contract, Record(took), lambda job: job.take_over(now_s), now_s)

    def _take(
        self, contract: Contract, how: Effect, begin: Callable[[TransportJob], None], now_s: float
    ) -> None:
        """Become the primary of a task, and free of everything else.

        Args:
            contract: of the task.
            how: said first: how it came to that.
            begin: the first step of the job.
            now_s: the present time.
        """
        self._bind(contract)
        taken = ContractTaken(
            task=contract.task, epoch=contract.epoch, role=Role.PRIMARY, coordinator=contract.coordinator
        )
        self._out += (how, Record(taken))
        self._standby.resign("has work of its own")
        self._idle.stop()
        self._work_search.stop()
        self._update_status(now_s, contract.task)
        self._go_on(begin, now_s)

    def _bind(self, contract: Contract) -> None:
        self._job = TransportJob(
            self.id,
            contract,
            plant=self._plant,
            vehicle_type=self._type,
            driver=self._driver,
            timers=self._timers,
            out=self._out,
        )
        self._commit()

    def _on_release(self, _sender: str, message: Release, now_s: float) -> None:
        if message.role is Role.SECONDARY:
            if not self._standby.release(message):
                self._out.append(Ignore("released from a watch that it does not keep"))
            return
        job = self._job
        if job is None or not self._concerns(job, message) or message.number != job.number:
            self._out.append(Ignore("released from a contract that it does not have"))
            return
        self._go_on(lambda job: job.cancel("released", now_s), now_s)

    def _on_of_contract(self, _sender: str, message: Any, now_s: float) -> None:
        job = self._job
        if job is None or not self._concerns(job, message):
            self._out.append(Ignore("an answer about another contract"))
            return
        self._go_on(lambda job: job.on_answer(message, now_s), now_s)

    def _on_of_dock(self, sender: str, message: DockOpened | DockHeld, now_s: float) -> None:
        if sender == message.station:
            self._on_of_contract(sender, message, now_s)
        else:
            self._out.append(Ignore(NO_PARTY))

    def _objection(self, sender: str, message: Message) -> str:
        return objection(sender, message, self._coordinator_of)

    def _coordinator_of(self, task: str, role: Role) -> str:
        """Who has given it a contract that it has; empty when it has none of this task in this role."""
        if role is Role.SECONDARY:
            return self._standby.coordinator_of(task)
        job = self._job
        return job.coordinator if job is not None and job.task == task else ""

    @staticmethod
    def _concerns(job: TransportJob, message: Any) -> bool:
        """Whether its coordinator speaks of this contract; a Superseded speaks of another epoch."""
        return job.task == message.task and (type(message) is Superseded or message.epoch == job.epoch)

    def _has_contract(self, task: str, epoch: int) -> bool:
        job = self._job
        if job is None or job.is_void:
            return False
        return job.task == task and job.epoch == epoch

    def _ask_again(self, _about: None, now_s: float) -> None:
        self._go_on(lambda job: job.wake(self._load[0], now_s), now_s)

    def _claim_again(self, _about: None, now_s: float) -> None:
        if self._job is not None:
            self._job.claim_again(now_s)

    def _go_on(self, step: Callable[[TransportJob], None], now_s: float) -> None:
        """Let the job take a step, if there is one, and see to what that has changed."""
        job = self._job
        if job is None:
            return
        phase, memory = job.phase, job.memory()
        step(job)
        if job.phase is not phase:
            self._note_wait(job, phase, now_s)
        if self._shutdown.begun:
            job.give_back(GRACEFUL_SHUTDOWN, now_s)
        self._heartbeat_timer.at_once(now_s)
        if job.ended:
            self._end_job(job, now_s)
        elif job.memory() != memory:
            self._commit()

    def _note_wait(self, job: TransportJob, phase: Phase, now_s: float) -> None:
        """A phase of the job is over: remember how long it had to wait in it."""
        kind, took_s = self._plant.vehicle_types[self._type], now_s - self._phase_s
        self._phase_s = now_s
        if phase is Phase.LOADING and job.phase is Phase.CARRYING:
            self._waits.note(job.source, "", took_s - kind.load_s, now_s)
        elif phase is Phase.UNLOADING and job.phase is Phase.HANDING_OVER:
            self._waits.note(job.work.destination, "", took_s - kind.unload_s, now_s)

    def _end_job(self, job: TransportJob, now_s: float) -> None:
        ended = ContractEnded(task=job.task, epoch=job.epoch, role=Role.PRIMARY, reason=job.ended)
        self._out.append(Record(ended))
        self._job = None
        self._commit()
        if job.ended == HANDED_OVER:
            self._probation.note_done()
        self._assistance.over()
        self._update_status(now_s, job.ended)
        self._idle.soon(now_s)
        self._seek(now_s)

    # --- rest, and people ---

    def _rest_on(self, name: str, now_s: float) -> None:
        if not self._may_rest():
            return
        way = self._driver.way
        self._idle.wake(name, self._battery_frac, now_s)
        self._update_status(now_s, self._idle.dwell_point)
        if self._driver.way is not way:
            self._heartbeat_timer.at_once(now_s)

    def _may_rest(self) -> bool:
        return self._job is None and not self._is_stuck and not self._shutdown.begun

    @property
    def _is_stuck(self) -> bool:
        """Whether it stands until a person has seen to it."""
        return self._commands.stopped or bool(self._assistance.problem)

    def _on_claim(self, _sender: str, message: DwellPointClaimed, now_s: float) -> None:
        self._idle.on_claim(message, battery_frac=self._battery_frac, may_leave=self._may_rest(), now_s=now_s)

    def _on_command(self, sender: str, command: VehicleCommand, now_s: float) -> None:
        done = self._commands.on_command(sender, command, self._driver.position_m, now_s)
        # A refusal is kept too: what was refused must not be obeyed when it comes again in the next life.
        self._commit()
        if done:
            if command.kind is CommandKind.STOP:
                if self._job is not None:
                    self._assistance.wait(self._job.slack_s, now_s)
                self._standby.resign("stopped by an operator")
            elif command.kind is CommandKind.RESUME:
                self._end_trouble(now_s)
        self._update_status(now_s, command.kind.value)
        self._heartbeat_timer.at_once(now_s)

    # --- what others see ---

    def _update_status(self, now_s: float, reason: str) -> None:
        if self._commands.stopped:
            status = AtvStatus.STOPPED
        elif self._assistance.problem:
            status = AtvStatus.ERROR
        elif self._job is not None:
            status = AtvStatus.WORKING
        elif self._idle.charging:
            status = AtvStatus.CHARGING
        else:
            status = AtvStatus.IDLE
        if status is not self._status:
            self._status = status
            self._out.append(Record(AtvStatusChanged(status=status, reason=reason)))
            self._heartbeat_timer.at_once(now_s)


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
