"""An autonomous transport vehicle: bids, carries, watches, charges itself (paper, 3.2).

The state machine of the paper, as other agents see it:

    IDLE     bids for tasks announced near by; parks out of the way
    CHARGING bids too, as far as its battery allows
    WORKING  primary of one task (invariant 3), and of nothing else
    STOPPED  held by an operator: moves again only after an acknowledge and a resume (invariant 5)
    ERROR    cannot go on

STOPPED and ERROR end no contract: the job waits. The heartbeat tells how long (`assistance`); after that another
vehicle takes the task. A vehicle with only its radio keeps its task too, and takes no other. A vehicle that is
asked to leave resigns from its watches, and from a task without the load on board. If it cannot move, it leaves as
it is.
"""

from __future__ import annotations

from typing import cast

from dray.body import (
    ActionDone,
    ActionFailed,
    BodyState,
    LinkNoticed,
    NodePassed,
    Report,
    UnplacedVehicle,
    VehicleState,
    WayDone,
)
from dray.errors import ProtocolViolation
from dray.memory import WHOLE, AtvMemory, Memory, Note
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    BodyWait,
    CommandKind,
    Disbelieved,
    DwellPointClaimed,
    Link,
    Message,
    Reason,
    VehicleCommand,
)
from dray.messages.fact import AtvStatusChanged, LinkChanged
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.calls.help_calls import NotComing
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.contract_net.parties import objection
from dray.protocol.contract_net.trust.disbelief import DisbeliefHandling
from dray.protocol.liveness.suspicion import interval_s
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import Received
from dray.protocol.runtime.life import BEAT, Life
from dray.protocol.runtime.shutdown import CARRIER_LEAVES_WITHIN_S
from dray.protocol.runtime.trust import Trusts, trusts_nobody
from dray.protocol.traffic.driving.place_requests import Sign, unsigned
from dray.protocol.traffic.driving.right_of_way import RightOfWay
from dray.protocol.traffic.driving.wait import ShutOut
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.closure_handling import ClosureHandling
from dray.protocol.vehicle.contracts import Contracts, WorkEnded
from dray.protocol.vehicle.drivers.reserved_driver import ReservedDriver, driver_of
from dray.protocol.vehicle.drivers.traffic_handling import (
    Alone,
    Arrived,
    Doubled,
    HoldsDenied,
    RoomMade,
    handle_traffic,
)
from dray.protocol.vehicle.idle_positioning import CLAIM, SETTLE, IdlePositioning
from dray.protocol.vehicle.lost_memory import LostMemory
from dray.protocol.vehicle.obstacle_handling import ObstacleHandling
from dray.protocol.vehicle.people.assistance import Assistance
from dray.protocol.vehicle.people.command_handling import DENIED, CommandHandling
from dray.protocol.vehicle.people.problem_handling import ProblemHandling
from dray.protocol.vehicle.status_report import StatusReport
from dray.protocol.vehicle.unplaced import LOOK, UNPLACED, Unplaced


class CellSubscription:
    """The announcements that one vehicle follows: those for its present cell.

    Args:
        plant: its cells.
        keys: the plant's bus keys.
    """

    __slots__ = ("_cell", "_keys", "_life", "_plant")

    def __init__(self, plant: Plant, keys: Keys, life: Life) -> None:
        self._plant = plant
        self._keys = keys
        self._life = life
        self._cell = ""
        """The present cell; empty before the position is known."""

    def move(self, x_m: float, y_m: float) -> None:
        """Follow the cell of this position."""
        cell = self._plant.cell_of(x_m, y_m)
        if cell == self._cell:
            return
        if self._cell:
            self._life.unsubscribe(self._keys.transports(self._cell))
        self._life.subscribe(self._keys.transports(cell))
        self._cell = cell


class Atv(AgentBase):
    """One vehicle.

    Args:
        atv: its id in the plant's fleet.
        plant: the plant it works in.
        vehicle_type: id of its type; by default that of the fleet's entry.
        incarnation: how often it has been started.
        software: the version it runs, for its heartbeat.
        probation: transports to do well before it takes long ones; 0 for a known good agent.
        trusts: the trusted signers of people's grants.
        traffic: of the plant; None to drive without right of way, as if it were alone.
        sign_request: signs its messages to replicas of reservation tables.
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
        traffic: TrafficMap | None = None,
        sign_request: Sign = unsigned,
    ) -> None:
        super().__init__(atv, incarnation, leaves_within_s=CARRIER_LEAVES_WITHIN_S)
        self.sign_request = sign_request
        self.floor = plant = KnownFloor(plant)
        self._type = vehicle_type or plant.fleet[atv].type
        self._keys = Keys(plant.id)
        self._beat_key = self._keys.atv_heartbeat(atv)
        self._driver = driver_of(self, plant, self._type, traffic, self._life)
        self._cells = CellSubscription(plant, self._keys, self._life)
        self._charging = Charging(plant, self._type)
        self._contracts = Contracts(
            atv, plant, self._type, probation, self._driver, self._charging, self._life, self
        )
        self._idle = IdlePositioning(
            atv, plant, self._type, self._keys, self._charging, self._driver, self._life
        )
        authority, assistance = CommandAuthorisation(atv, plant, trusts), Assistance(self._life)
        self._commands = CommandHandling(authority, assistance, self._driver, self._charging, self._life)
        self._lost_memory = LostMemory(self._life)
        self._status_report = StatusReport(
            self,
            software,
            self._driver,
            self._contracts,
            self._idle,
            self._commands,
            self._lost_memory,
            self._life,
        )
        self._closures = ClosureHandling(plant, trusts, self._contracts, self._idle, self._life)
        self.problems = ProblemHandling(
            self, plant, self._driver, self._contracts, self._commands, self._life
        )
        self.obstacles = ObstacleHandling(
            self, plant, self._driver, self._contracts, self._idle, self.problems, self._life
        )
        self._unplaced: Unplaced | None = None
        """The wait for its place; None when its body has told one."""
        self.link = Link.WLAN
        self._status = AtvStatus.IDLE
        self.battery_frac, self.battery_reckoned = 1.0, False
        self.load = ("", 0)
        self.body_wait: BodyWait | None = None
        self._message_handlers = {
            **self._contracts.message_handlers,
            **self._closures.message_handlers,
            **self.problems.messages,
            **self.obstacles.messages,
            VehicleCommand: self._on_command,
            DwellPointClaimed: self._on_claim,
            Disbelieved: DisbeliefHandling(self._life).on_disbelieved,
        }
        self._report_handlers = {
            NodePassed: self._node_passed,
            WayDone: self._way_done,
            ActionDone: self._action_done,
            ActionFailed: self._action_failed,
            **self.problems.reports,
            **self.obstacles.reports,
            LinkNoticed: self._link_noticed,
        }
        self._alarm_handlers = {
            BEAT: self._beat,
            **self._contracts.alarms,
            **self._closures.alarms,
            **self.problems.alarms,
            **self.obstacles.alarms,
            LOOK: lambda _about, now_s: self._look_for_place(now_s),
            SETTLE: lambda _about, now_s: self._rest_on(SETTLE, now_s),
            CLAIM: lambda _about, now_s: self._rest_on(CLAIM, now_s),
        }
        self._reactions = {
            Arrived: lambda _change, now_s: self.note_arrived(now_s),
            RoomMade: lambda _change, now_s: self.note_makes_room(now_s),
            HoldsDenied: lambda _change, now_s: self.note_denied(now_s),
            Doubled: lambda _change, now_s: self.problems.note_doubled(now_s),
            Alone: lambda _change, now_s: self.problems.note_alone(now_s),
            ShutOut: self.obstacles.shut_out,
            WorkEnded: self._on_work_ended,
            NotComing: lambda change, now_s: self.problems.not_coming(change.since_s, now_s),
        }
        handle_traffic(self._driver, plant, self._life, self._message_handlers, self._alarm_handlers)

    # --- the beginning, and time passing ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        if isinstance(body, UnplacedVehicle):
            self._unplaced = Unplaced(self.id, self.floor, self.problems.calls, self._life)
            self._unplaced.start(body, memory, now_s)
        else:
            self._begin(body, memory, now_s)

    def _begin(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        """Begin its life at the place that its body has told."""
        self._sense(body, now_s)
        self._cells.move(*self._driver.position_m)
        self._closures.start(memory, now_s)
        self.obstacles.start()
        state = cast(VehicleState, body)
        self._driver.take_control(state, now_s)
        note = memory.get(WHOLE)
        self.problems.start(state, note.problem if isinstance(note, AtvMemory) else None, now_s)
        self.link = state.link
        self._commands.stopped = state.held
        if isinstance(note, AtvMemory):
            self._commands.restore(note)
            self._lost_memory.restore(note)
            for ended in note.put_down:
                self._contracts.put_down.add(ended, now_s)
        else:
            self._commands.forget()
            if self.incarnation > 1:
                self._lost_memory.start(state.node)
        self._lost_memory.sense(state.node, state.load)
        if isinstance(note, AtvMemory) and note.contract is not None:
            self._contracts.bind(note.contract)
            self._contracts.go_on(lambda job: job.resume(state.load, now_s), now_s)
        self._contracts.bring_back(now_s)
        self._charging.note(self.battery_frac, self._driver.next_node)
        if self._contracts.job is None:
            self._idle.start(self.battery_frac, now_s)
        self.update_status(now_s, "started")
        self._life.beat_soon(now_s)

    def _memory(self) -> Note:
        job = self._contracts.job
        return AtvMemory(
            contract=job.memory() if job is not None else None,
            acknowledged=self._commands.acknowledged,
            stopped_itself=self._commands.stopped_itself,
            stop_cause=self._commands.stop_cause,
            speed_frac=self._driver.speed_frac,
            out_of_service=self._commands.out_of_service,
            sent_to_charge=self._commands.is_sent_to_charge,
            answered=self._commands.answered,
            problem=self.problems.memory,
            node=self._driver.node,
            put_down=self._contracts.put_down.memories(),
            forgot_at=self._lost_memory.node,
            left_empty=self._lost_memory.is_left,
        )

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        unplaced = self._unplaced
        if isinstance(body, UnplacedVehicle):
            if unplaced is not None:
                unplaced.sense(body)
            return
        if unplaced is not None:
            self._unplaced = None
            unplaced.stop()
            self._begin(body, unplaced.memory, now_s)
            return
        if not isinstance(body, VehicleState):
            raise ProtocolViolation(f"{self.id}: a vehicle needs a vehicle's body, not {body!r}")
        self._driver.sense(body)
        self.battery_frac, self.battery_reckoned = body.battery_frac, body.battery_reckoned
        self.load = (body.load, body.load_quantity)
        self.body_wait = body.wait
        self._lost_memory.sense(body.node, body.load)

    def _beat(self, _about: None, now_s: float) -> None:
        self._contracts.check_load(now_s)
        self._contracts.bring_back(now_s)
        self.problems.update_call(now_s)
        self._life.beat_again(interval_s(self._say_status(now_s)), now_s)
        self._charging.note(self.battery_frac, self._driver.next_node)
        if self._contracts.job is None:
            self._idle.check_battery(self.battery_frac, now_s)
            self._contracts.seek(now_s)

    def _say_status(self, now_s: float) -> AtvHeartbeat:
        heartbeat = self._status_report.heartbeat(self._status, self.link, now_s)
        self._life.publish(self._beat_key, heartbeat)
        return heartbeat

    def _was_deaf(self, span_s: float) -> None:
        self._contracts.subscriptions.arrivals.deaf_s += span_s

    # --- the end ---

    def _prepare_to_leave(self, now_s: float) -> None:
        if self._unplaced is not None:
            self._unplaced.leave(now_s)
            return
        self._contracts.standby.resign(Reason.GRACEFUL_SHUTDOWN)
        if self._contracts.job is None:
            self._idle.stay(now_s)
        else:
            self._contracts.job.give_back(Reason.GRACEFUL_SHUTDOWN, now_s)
        self._life.beat_soon(now_s)

    def _is_held(self) -> bool:
        if self._unplaced is not None:
            return False
        job = self._contracts.job
        if self._is_stuck:
            return job is not None and job.is_given_back
        return job is not None or bool(self._driver.way)

    def _take_leave(self, now_s: float) -> None:
        if self._unplaced is None:
            self._say_status(now_s)

    # --- while its body has told no place ---

    def _on_message(self, received: Received, now_s: float) -> None:
        if self._unplaced is None:
            super()._on_message(received, now_s)
        elif (handle := self._unplaced.message_handlers.get(type(received.message))) is not None:
            handle(received.sender, received.message, now_s)
        else:
            self._life.ignore(UNPLACED)

    def _look_for_place(self, now_s: float) -> None:
        if self._unplaced is not None:
            self._unplaced.look(now_s)

    def _on_report(self, report: Report, now_s: float) -> None:
        # Its next state says the same.
        if self._unplaced is None:
            super()._on_report(report, now_s)

    # --- the body reports ---

    def _node_passed(self, report: NodePassed, now_s: float) -> None:
        before = self._driver.node
        self._driver.on_passed(report, now_s)
        self.obstacles.drove(before, report.node, now_s)
        self.battery_frac = report.battery_frac
        self._cells.move(*self._driver.position_m)

    def _way_done(self, report: WayDone, now_s: float) -> None:
        if self._driver.on_done(report, now_s):
            self.note_arrived(now_s)

    def note_arrived(self, now_s: float) -> None:
        if self._contracts.job is not None:
            self._contracts.go_on(lambda job: job.arrived(now_s), now_s)
        else:
            self._idle.arrived(now_s)
            self.update_status(now_s, self._idle.dwell_point)
        self._life.beat_soon(now_s)

    def _action_done(self, report: ActionDone, now_s: float) -> None:
        if self._idle.action_done(report.order, now_s):
            self.update_status(now_s, "charged")
        else:
            self._contracts.go_on(lambda job: job.action_done(report.order, now_s), now_s)

    def _action_failed(self, report: ActionFailed, now_s: float) -> None:
        if self._idle.action_failed(report.order, now_s):
            self.update_status(now_s, report.reason)
        elif self._driver.on_failed(report, now_s):
            if self._contracts.job is not None:
                self._contracts.job.way_refused(now_s)
            else:
                self._idle.soon(now_s)
        else:
            self._contracts.go_on(lambda job: job.action_failed(report.order, report.reason, now_s), now_s)

    def end_trouble(self, now_s: float) -> None:
        if self._is_stuck:
            return
        self._commands.assistance.over()
        if self._contracts.job is None:
            self._idle.soon(now_s)

    def _link_noticed(self, report: LinkNoticed, now_s: float) -> None:
        if report.link is self.link:
            return
        self.link, self._status_report.access_point = report.link, report.access_point
        self._life.record(LinkChanged(link=report.link))
        self.obstacles.tell(now_s)
        if report.link is Link.MESH:
            self._contracts.standby.resign(Reason.ON_MESH)
        self._life.beat_soon(now_s)

    # --- for its contracts (`dray.protocol.vehicle.contracts.Owner`) ---

    @property
    def right_of_way(self) -> RightOfWay | None:
        """Its right of way, once its life has begun; None if it drives without one."""
        driver = self._driver
        return driver.right_of_way if isinstance(driver, ReservedDriver) and driver.node else None

    @property
    def is_busy(self) -> bool:
        return self._contracts.job is not None

    @property
    def is_draining(self) -> bool:
        return self._shutdown.begun

    @property
    def gives_back(self) -> Reason | None:
        """Why it gives back a task whose load is not on board; None if it does not."""
        if self._shutdown.begun:
            return Reason.GRACEFUL_SHUTDOWN
        out = self._commands.out_of_service
        return None if out is None or out.after_work else Reason.OUT_OF_SERVICE

    def is_reserve(self, now_s: float) -> bool:
        return self._idle.is_reserve(now_s)

    def unfit(self) -> str:
        return self._status_report.unfit(self.link)

    def stop_resting(self, now_s: float) -> None:
        self._idle.stop(now_s)

    def _on_work_ended(self, ended: WorkEnded, now_s: float) -> None:
        """Rest until there is other work."""
        self._commands.assistance.over()
        self.obstacles.note_ended(now_s)
        self.update_status(now_s, ended.reason)
        self._driver.rest(now_s)
        self._idle.soon(now_s)

    def note_makes_room(self, now_s: float) -> None:
        if self._contracts.job is None and not self._driver.way:
            self._idle.seek_anew(now_s)

    def note_denied(self, now_s: float) -> None:
        """A person said that it was carried away, but it drives: it stops, and calls until a person has checked it."""
        self._commands.stop_itself(DENIED)
        self._wait_for_person(Reason.PROBLEM, now_s)
        self.update_status(now_s, DENIED)

    def _objection(self, sender: str, message: Message) -> str:
        return objection(sender, message, self._contracts.coordinator_of)

    # --- rest, and people ---

    def _rest_on(self, name: str, now_s: float) -> None:
        if not self._may_rest():
            return
        way = self._driver.way
        self._idle.wake(name, self.battery_frac, now_s)
        self.update_status(now_s, self._idle.dwell_point)
        if self._driver.way is not way:
            self._life.beat_soon(now_s)

    def _may_rest(self) -> bool:
        return self._contracts.job is None and not self._is_stuck and not self._shutdown.begun

    @property
    def _is_stuck(self) -> bool:
        return self._commands.stopped or bool(self._commands.assistance.problem)

    def _on_claim(self, _sender: str, message: DwellPointClaimed, now_s: float) -> None:
        self._idle.on_claim(message, battery_frac=self.battery_frac, may_leave=self._may_rest(), now_s=now_s)

    def _on_command(self, sender: str, command: VehicleCommand, now_s: float) -> None:
        done = self._commands.on_command(sender, command, self._driver.position_m, now_s)
        # A refusal is stored too: the command must not be obeyed when it is repeated in the next life.
        self._life.commit()
        if done:
            if command.kind is CommandKind.STOP:
                self._wait_for_person(Reason.STOPPED, now_s)
            elif command.kind is CommandKind.RESUME:
                self.end_trouble(now_s)
            elif command.kind is CommandKind.TAKE_OUT:
                self._contracts.standby.resign(Reason.OUT_OF_SERVICE)
                self._contracts.go_on(lambda _job: None, now_s)
            elif command.kind is CommandKind.PUT_IN and not self.is_busy:
                self._contracts.seek(now_s)
        self.update_status(now_s, command.kind.value)
        self._life.beat_soon(now_s)

    def _wait_for_person(self, reason: Reason, now_s: float) -> None:
        """It stands stopped: its task waits for a person, and it watches no other vehicle."""
        if self._contracts.job is not None:
            self._commands.assistance.wait(self._contracts.job.waiting(now_s), now_s)
        self._contracts.standby.resign(reason)

    # --- the status ---

    def update_status(self, now_s: float, reason: str) -> None:
        """Update the status, and report the reason if it has changed."""
        self._driver.be_stuck(self._is_stuck, now_s)
        status = self._status_report.status
        if status is not self._status:
            self._status = status
            self._life.record(AtvStatusChanged(status=status, reason=reason))
            self._life.beat_soon(now_s)
