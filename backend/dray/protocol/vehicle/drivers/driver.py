"""A vehicle's position on the lanes, and its ways to other nodes."""

from __future__ import annotations

from msgspec import UNSET, UnsetType

from dray.body import (
    SLOWEST_FRAC,
    ActionFailed,
    Drive,
    LimitSpeed,
    NodePassed,
    VehicleInstruction,
    VehicleState,
    WayDone,
)
from dray.errors import NoWay
from dray.messages import AtvHeartbeat, Pose
from dray.messages.heartbeat import FloorBrief
from dray.plant import Plant, Routes
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.wait import ShutOut

ORDERS_PER_LIFE = 1_000_000
"""Order numbers per incarnation, so that late reports to an earlier life are recognised."""


def limited_s(way_s: float, speed_frac: float) -> float:
    """Maximum duration of a way at a fraction of the vehicle's top speed (s); its lanes may be slower anyway."""
    return way_s / max(speed_frac, SLOWEST_FRAC)


class Driver:
    """Turns destinations into ways, and reports into positions.

    The whole way is released at once. `ReservedDriver` releases only what the vehicle holds.

    Args:
        plant: its lanes.
        vehicle_type: id of the vehicle's type.
        first_order: first order number of ways and actions.
    """

    def __init__(self, plant: Plant, vehicle_type: str, life: Life, *, first_order: int = 0) -> None:
        self._plant, self._type = plant, vehicle_type
        self._life = life
        self._passed = 0
        self.node = ""
        """The last node that was passed."""
        self.pose = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
        self.speed_mps = 0.0
        self.order = first_order
        """The number of the newest way or action; reports about older ones are ignored."""
        self.way: tuple[str, ...] = ()
        """The whole present way; empty if the vehicle stands."""
        self.arrives_s = 0.0
        """Expected end of the present way (plant clock, s)."""
        self.speed_frac = 1.0
        """The limit set by a person, as a fraction of the vehicle's top speed."""

    @property
    def pace_frac(self) -> float:
        """The effective speed as a fraction of its top speed; promises use it."""
        return self.speed_frac

    @property
    def ahead(self) -> tuple[str, ...]:
        """The nodes of the way that were not passed yet."""
        return self.way[self._passed :]

    @property
    def next_node(self) -> str:
        """The node where another way could begin."""
        return self.way[self._passed] if self._passed < len(self.way) else self.node

    @property
    def next_node_in_m(self) -> float:
        """The way to the next node."""
        if self._passed >= len(self.way):
            return 0.0
        target = self._plant.nodes[self.next_node]
        return abs(target.x_m - self.pose.x_m) + abs(target.y_m - self.pose.y_m)

    def next_node_at_s(self, now_s: float) -> float:
        """Estimated time at the next node, by the present speed."""
        return now_s + self.next_node_in_m / max(self.speed_mps, 0.3)

    @property
    def position_m(self) -> tuple[float, float]:
        """The last sensed position (x, y) in m."""
        return self.pose.x_m, self.pose.y_m

    def sense(self, state: VehicleState) -> None:
        """Take the position from the vehicle's body."""
        self.pose, self.node, self.speed_mps = state.pose, state.node, state.speed_mps

    def take_control(self, state: VehicleState, now_s: float) -> None:
        """End an earlier life's way at the end of the present lane."""
        if state.next_node != state.node:
            self._take_way((state.next_node,), state.next_node_s, now_s)

    def go(self, node: str, now_s: float) -> bool:
        """Drive to a node.

        Returns:
            False if the vehicle stands there already; nothing is done then.

        Raises:
            NoWay: closures leave no way; nothing is done then.
        """
        if not self.way and self.node == node:
            return False
        way = self._routes.way(self.next_node, node)
        self._take_way(way.nodes, limited_s(way.duration_s, self.speed_frac), now_s)
        return True

    def halt(self, now_s: float) -> None:
        """Stop at the end of the present lane, or at the next open node if that end was closed."""
        here = self.next_node
        try:
            stands = self._routes.way_out(here, self._plant.stops).nodes[-1]
        except NoWay:
            stands = here
        if self.way or stands != here:
            self.go(stands, now_s)

    def follow(self, now_s: float) -> bool:
        """The floor has changed: plan the rest of the way anew, and leave closed nodes.

        Returns:
            False if the destination cannot be reached any more; the vehicle halts then.
        """
        if self.way:
            try:
                return self.go(self.way[-1], now_s)
            except NoWay:
                self.halt(now_s)
                return False
        if self.node in self._plant.restrictions.nodes:
            self.halt(now_s)
        return True

    @property
    def goal(self) -> str:
        """Its destination, or the node where it stands."""
        return self.way[-1] if self.way else self.node

    def leads_round(self, node: str, _now_s: float) -> bool:
        """Whether a way without known obstacles leads from a node to its destination, and it would take that way."""
        return self._routes.leads_round(node, self.goal)

    def turn_back(self, node: str, now_s: float, goal: str = "") -> bool:
        """Take another way from the node before an obstructed lane.

        Args:
            node: the node where it stands.
            now_s: the present time.
            goal: the destination; empty for the present one.

        Returns:
            False if the vehicle has left the node; nothing is done then.
        """
        if self.node != node or not self.way:
            return False
        goal, self.way, self._passed = goal or self.way[-1], (), 0
        self.go(goal, now_s)
        return True

    @property
    def _routes(self) -> Routes:
        return self._plant.routes(self._type)

    def limit_speed(self, speed_frac: float) -> None:
        """Limit the speed to a fraction of the vehicle's top speed from now on."""
        self.speed_frac = speed_frac
        self._life.instruct(LimitSpeed(speed_frac=speed_frac))

    def _take_way(self, nodes: tuple[str, ...], duration_s: float, now_s: float) -> None:
        self.order += 1
        self.way, self._passed = nodes, 0
        self.arrives_s = now_s + duration_s
        limits_mps = self._plant.restrictions.limits_on(nodes)
        drive = Drive(order=self.order, nodes=nodes, released=len(nodes), limits_mps=limits_mps)
        self._life.instruct(drive)

    def act(self, instruction: VehicleInstruction) -> None:
        """Instruct the standing vehicle; number the instruction with `next_order` first."""
        self._life.instruct(instruction)

    def next_order(self) -> int:
        """A fresh order number."""
        self.order += 1
        return self.order

    def on_passed(self, report: NodePassed, now_s: float) -> None:
        """A node was reached."""
        self.node = report.node
        spot = self._plant.nodes[report.node]
        self.pose = Pose(x_m=spot.x_m, y_m=spot.y_m, heading_rad=self.pose.heading_rad)
        if report.order == self.order and self.way:
            self._passed = report.index + 1

    def on_done(self, report: WayDone, now_s: float) -> bool:
        """The vehicle has stopped at the end of a way; False for an older way."""
        self.node = report.node
        if report.order != self.order:
            return False
        self.way, self._passed, self.speed_mps = (), 0, 0.0
        return True

    def on_failed(self, report: ActionFailed, now_s: float) -> bool:
        """The way was refused; False for an older way, or none."""
        if report.order != self.order or not self.way:
            return False
        self.way, self._passed = (), 0
        return True

    # --- right of way ----------------------------------------------------------------------------

    def rest(self, now_s: float) -> None:
        """The task is over: make room for others."""

    def be_stuck(self, stuck: bool, now_s: float) -> None:
        """The vehicle cannot move until a person has checked it, or can move again."""

    def shut_out_by(self, _failed: AtvHeartbeat) -> ShutOut | None:
        """What a failed vehicle that stands there blocks on this one's way; None if nothing."""
        return None

    def expect_at(self, place: str, comes_s: float, stays_s: float, *, docked: bool = False) -> None:
        """Publish the vehicle's times at a place, if others need them.

        Args:
            place: the place of loading or unloading.
            comes_s: arrival time (plant clock).
            stays_s: duration of the stay; 0 when it is done.
            docked: whether it stands there.
        """

    @property
    def is_placed(self) -> bool:
        """Whether the vehicle holds the place where it stands."""
        return True

    def floor(self, now_s: float) -> FloorBrief | UnsetType:
        """The vehicle's reservations on the floor, for its heartbeat."""
        return UNSET
