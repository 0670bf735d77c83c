"""A simulated vehicle: it drives released ways, loads and unloads, charges, and can break down.

It implements `dray.ports.Body`. Ways have a released part (VDA 5050's base) and one that is not (horizon), picking
and dropping are actions, and impossible instructions are reported. It leaves all decisions to its agent, and does not
see other vehicles.

Nothing ticks. A moving vehicle has a speed profile (`travel`), a working one a time when the action ends
(`handling`). Its position and its battery level (`power`) follow in closed form. One call of the clock is open at a
time, for the next node or the end of the action. It carries the number of its plan, and a change of plan makes it
stale. Another watches the battery.

    standing --Drive--> driving --WayDone--> standing --Pick, Drop, Charge--> acting --> standing
    Hold, a breakdown and an empty battery stop either; the rest of the way or action is kept.
    Without power it stands in that moment, and has forgotten both when the power is back.

An action needs a vehicle that stands at the station's node with its way finished. A new way ends it: a pick or drop with a failure.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from dray.body import (
    ActionFailed,
    Charge,
    Drive,
    Drop,
    Hold,
    Instruction,
    LimitSpeed,
    LinkNoticed,
    NodePassed,
    Pick,
    ReleaseWay,
    Report,
    Unhold,
    VehicleState,
    WayBlocked,
    WayDone,
    WayFree,
)
from dray.messages import NOTHING_KNOWN, Link, Pose, Problem
from dray.plant import Plant
from dray.plant.model import VehicleSpec, VehicleType
from dray.ports import Clock
from dray_sim.bodies.obstacles import Ends, Obstacles
from dray_sim.bodies.reporter import Reporter
from dray_sim.bodies.stands import Stands
from dray_sim.bodies.vehicle.condition import LOAD_SHIFTED, SHIFTED, Condition
from dray_sim.bodies.vehicle.course import Course
from dray_sim.bodies.vehicle.handling import Action, Handling
from dray_sim.bodies.vehicle.odometer import Activity, Odometer
from dray_sim.bodies.vehicle.power import Power
from dray_sim.bodies.vehicle.travel import NEVER_S, Travel
from dray_sim.bodies.vehicle.way import Way

MOVED_BY_HAND = "moved by hand"


class ObstacleDetection:
    """Reports the obstacle before one vehicle.

    Args:
        vehicle: its id.
        travel: its movement.
        reporter: its reports.
    """

    def __init__(self, vehicle: str, travel: Travel, reporter: Reporter) -> None:
        self._vehicle, self._travel, self._reporter = vehicle, travel, reporter
        self._seen: tuple[int, Ends] | None = None

    def look(self) -> None:
        """Look again: its motion or an obstacle has changed."""
        travel = self._travel
        if travel.doors is not None:
            travel.doors.heed(self._vehicle, travel.enters, travel.asks)
        lane = travel.blocked
        seen = None if travel.way is None or lane is None else (travel.way.order, lane)
        before, self._seen = self._seen, seen
        if seen == before:
            return
        if before is not None and travel.is_clear(before[1]):
            order, (start, end) = before
            self._reporter.say(WayFree(order=order, start=start, end=end))
        if seen is not None:
            order, (start, end) = seen
            self._reporter.say(WayBlocked(order=order, start=start, end=end, entered=travel.entered))


class SimVehicle:
    """Implements `dray.ports.Body`.

    Invariants: a held, broken or empty vehicle comes to a stand and does not start (invariant 5), also when its power
    is back. Only a place or a person that gives or receives pieces changes the load; `battery_frac` is in 0..1.

    Args:
        spec: its id, and its node at the beginning.
        vehicle_type: its abilities.
        plant: roads and stations.
        clock: the plant's clock.
        stands: where it can load, unload and charge.
        seed: how long each manoeuvre takes follows from it, where that varies.
        obstacles: on the lanes; shared by the fleet.

    Attributes:
        id: the vehicle's id.
    """

    def __init__(
        self,
        spec: VehicleSpec,
        vehicle_type: VehicleType,
        plant: Plant,
        clock: Clock,
        stands: Stands,
        seed: int = 0,
        obstacles: Obstacles | None = None,
    ) -> None:
        self.id = spec.id
        self._type = vehicle_type
        self._clock = clock
        self._reporter = Reporter(clock)
        self._travel = Travel(plant, vehicle_type, spec.node, clock.now_s(), obstacles)
        self._detection = ObstacleDetection(spec.id, self._travel, self._reporter)
        self._handling = Handling(spec.id, vehicle_type, plant, stands, self._reporter, seed)
        self._power = Power(
            vehicle_type,
            spec.battery_frac,
            clock,
            self._travel,
            self._handling,
            charging=lambda: self._charging,
            look=self._look_at_battery,
        )
        self._condition = Condition(self._power, self._reporter)
        self._link = Link.WLAN
        self._sums = Odometer()
        """Sums up to the moment in which the power was settled."""
        self._plan = 0
        """The number of the present plan: a call of the clock for another one is stale."""
        self._due_s = NEVER_S
        """When the present plan ends."""
        self._on_course: tuple[Callable[[str, Course], None], ...] = ()
        self._power.watch()

    # --- Body ------------------------------------------------------------------------------------

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Without power it hears nothing; instructions for workcells are ignored."""
        if self._power.off:
            return
        self._settle()
        match instruction:
            case Drive():
                self._drive(instruction)
            case ReleaseWay(order, released):
                self._travel.release(order, released, self._power.settled_s)
            case Pick() | Drop() | Charge():
                self._act(instruction)
            case Hold() | Unhold():
                self._condition.held = isinstance(instruction, Hold)
                self._obey_stops()
            case LimitSpeed(speed_frac):
                self._travel.limit(speed_frac, self._power.settled_s)
        self._schedule()
        self._reporter.flush_soon()

    def sense(self) -> VehicleState:
        """See `dray.ports.Body`."""
        now_s, travel = self._now_s(), self._travel
        pose, next_node, next_node_s, speed_mps = travel.whereabouts(now_s)
        return VehicleState(
            pose=pose,
            node=travel.node,
            next_node=next_node,
            next_node_s=next_node_s,
            speed_mps=speed_mps,
            battery_frac=self._power.level(now_s),
            load=self._handling.load,
            load_quantity=self._handling.quantity,
            held=self._condition.held,
            charging=self._charging,
            link=self._link,
            problem=self.problem,
            about_problem=self._condition.about_problem,
            base_end=travel.base_end,
        )

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._reporter.attach(report)

    # --- the world -------------------------------------------------------------------------------

    @property
    def pose(self) -> Pose:
        """Its position and heading now."""
        return self._travel.pose(self._now_s())

    @property
    def problem(self) -> str:
        """The reason why it cannot go on; empty for none."""
        return self._condition.problem

    @property
    def off(self) -> bool:
        return self._power.off

    @property
    def stopped(self) -> bool:
        return self._condition.stopped

    def notice_link(self, link: Link, access_point: str = "") -> None:
        """The modem has lost the WLAN or is back on it; told when that is a change."""
        if link is not self._link:
            self._link = link
            self._reporter.say(LinkNoticed(link=link, access_point=access_point))
            self._reporter.flush_soon()

    def power_off(self) -> None:
        """Stand still in this moment, deaf and mute; harmless when it is off already.

        It keeps its place, load, battery, plug, faults, a hold and a speed limit. It loses the way, and a pick, drop
        or charge in progress, without a report.
        """
        if self._power.off:
            return
        self._settle()
        self._power.off = True
        self._handling.finish_action()
        self._travel.strand(self._power.settled_s)
        self._reporter.mute()
        self._schedule()

    def power_on(self) -> None:
        """Wake up where it stands, and stay there until the next instruction; harmless when it is on."""
        if not self._power.off:
            return
        self._settle()
        self._power.off = False
        self._reporter.unmute()
        self._change_of_fortune()

    def shift_load(self) -> bool:
        """Let the load slip, on board or on its way on or off; False when there is none.

        The vehicle stands until that is repaired.
        """
        if not self._handling.load and not isinstance(self._handling.action, Pick):
            return False
        self.break_down(LOAD_SHIFTED, SHIFTED)
        return True

    def follow(self, action: Pick | Drop) -> str:
        """Repeat the pick or drop of the vehicle whose double this is; returns why not, or ""."""
        return self._handling.follow(action)

    def recover_load(self) -> tuple[str, int]:
        """A person takes the load off (item, pieces; `("", 0)` for nothing), and answers for it from now on."""
        self._settle()
        load = self._handling.take_off()
        if isinstance(self._handling.action, Drop):
            self._handling.abort("the load was taken off by hand")
        self._change_of_fortune()
        return load

    def place_at(self, node: str) -> None:
        """Let people push or carry it to a node; with an empty node it is off the floor.

        Its way and action end without effect.
        """
        self._settle()
        if self._travel.way is not None:
            self._fail(self._travel.way.order, MOVED_BY_HAND)
        self._handling.abort(MOVED_BY_HAND)
        self._handling.unplug()
        self._travel.place_at(node, self._power.settled_s)
        self._change_of_fortune()

    def break_down(self, reason: str, problem: Problem = NOTHING_KNOWN) -> None:
        """Stop as if held, and say why. Another breakdown on top of it replaces the reason."""
        self._settle()
        self._condition.break_down(reason, problem)
        self._change_of_fortune()

    def repair(self) -> None:
        """Go on; harmless when nothing is broken. An empty battery is another problem, and stays."""
        if not self._condition.fault:
            return
        self._settle()
        self._condition.mend()
        self._change_of_fortune()

    def replace_battery(self, level_frac: float = 1.0) -> None:
        """Replace its battery; an empty vehicle goes on with its work."""
        self._settle()
        self._power.level_frac = level_frac
        self._condition.revive()
        self._change_of_fortune()

    @property
    def can_stop(self) -> bool:
        """Whether it can brake in time before any obstacle in its way."""
        return self._travel.can_stop(self._now_s())

    def look(self) -> None:
        """Something was put on a lane, or is gone."""
        self._settle()
        self._travel.look(self._power.settled_s)
        self._schedule()
        self._reporter.flush_soon()

    def watch_course(self, on_course: Callable[[str, Course], None]) -> None:
        """Add an observer of its course, who is told now and at every change."""
        self._on_course += (on_course,)
        on_course(self.id, self._travel.course(self._now_s()))

    def odometer(self) -> Odometer:
        """Metres and seconds from the beginning until now."""
        return self._add_to(self._sums.copy(), self._now_s())

    # --- instructions ----------------------------------------------------------------------------

    def _drive(self, drive: Drive) -> None:
        travel, now_s = self._travel, self._power.settled_s
        reason = travel.drive(drive.order, drive.nodes, drive.released, now_s, drive.limits_mps)
        if reason:
            self._fail(drive.order, reason)
            travel.cut(now_s)
            return
        if self._handling.action is not None:
            self._handling.abort("a new way was given")
        self._handling.unplug()
        if (way := travel.way) is not None and not way.lead:
            self._pass_node(way, 0)

    def _act(self, action: Action) -> None:
        if isinstance(self._handling.action, Charge):
            self._handling.abort("")
        busy = self._travel.way is not None
        reason = "the way is not finished" if busy else self._handling.start_action(action, self._travel.node)
        if reason:
            self._fail(action.order, reason)
        elif isinstance(action, Charge):
            self._condition.revive()
            self._obey_stops()

    # --- what happens at its time ----------------------------------------------------------------

    def _due(self, plan: int) -> None:
        """The next node is reached, or the action has ended."""
        if plan != self._plan:
            return
        self._settle()
        way, action = self._travel.way, self._handling.action
        if way is not None:
            self._pass_node(way, self._travel.arrive())
        elif action is not None:
            if isinstance(action, Charge):
                self._power.level_frac = 1.0
            self._handling.finish(action)
        self._schedule()
        self._reporter.flush()

    def _pass_node(self, way: Way, index: int) -> None:
        node = self._travel.node
        report = NodePassed(order=way.order, node=node, index=index, battery_frac=self._power.level_frac)
        self._reporter.say(report)
        if self._travel.finish(self._power.settled_s):
            self._reporter.say(WayDone(order=way.order, node=node))

    def _fail(self, order: int, reason: str) -> None:
        self._reporter.say(ActionFailed(order=order, reason=reason))

    # --- stops and plans -------------------------------------------------------------------------

    @property
    def _charging(self) -> bool:
        return isinstance(self._handling.action, Charge) and not self.stopped

    def _change_of_fortune(self) -> None:
        """Something outside has changed: stop or go on, and tell."""
        self._obey_stops()
        self._schedule()
        self._reporter.flush_soon()

    def _obey_stops(self) -> None:
        if self.stopped:
            self._travel.halt(self._power.settled_s)
        else:
            self._travel.go_on(self._power.settled_s)

    def _schedule(self) -> None:
        """Ask to be called at the end of the present plan; calls for earlier plans are stale now."""
        self._plan += 1
        when_s = NEVER_S
        if self._travel.way is not None:
            when_s = self._travel.next_at_s
        elif self._handling.action is not None and not self.stopped:
            charging_s = self._power.charging_s
            left_s = charging_s if self._charging else self._handling.left_s
            when_s = self._power.settled_s + left_s
        self._due_s = when_s
        if when_s < NEVER_S:
            self._clock.call_at(when_s, partial(self._due, self._plan))
        self._power.watch()
        self._detection.look()
        if self._on_course:
            course = self._travel.course(self._power.settled_s)
            for watcher in self._on_course:
                watcher(self.id, course)

    def _look_at_battery(self) -> None:
        """The battery may be empty."""
        self._settle()
        if not self._power.is_spent:
            self._power.watch()
            return
        self._condition.run_flat()
        self._travel.stop_dead(self._power.settled_s)
        self._schedule()
        self._reporter.flush()

    def _now_s(self) -> float:
        """The time, which stands still at the end of a plan until the clock calls: a real one calls late."""
        return min(self._clock.now_s(), self._due_s)

    def _settle(self) -> None:
        """Bring battery, odometer and action up to now."""
        now_s = self._now_s()
        passed_s = now_s - self._power.settled_s
        if not passed_s:
            return
        self._add_to(self._sums, now_s)
        self._power.settle(now_s)
        if not self.stopped:
            self._handling.spend(passed_s)

    def _add_to(self, sums: Odometer, now_s: float) -> Odometer:
        """Add the time since it was settled."""
        return sums.add(self._travel, self._power, self._activity, now_s, loaded=bool(self._handling.load))

    def _activity(self) -> Activity:
        return self._condition.activity(self._handling.action, waits=self._travel.waits)
