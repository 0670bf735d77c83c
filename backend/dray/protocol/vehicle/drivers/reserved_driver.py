"""A driver with right of way: it enters only places that the vehicle holds, and makes room for others."""

from __future__ import annotations

from itertools import pairwise
from typing import Protocol

from msgspec import UNSET

from dray.body import ActionFailed, NodePassed, VehicleState, WayDone
from dray.errors import NoWay, ProtocolViolation
from dray.messages import AtvHeartbeat, DockExpected, Pose
from dray.messages.floor.traffic import HOLDS_MAX
from dray.messages.heartbeat import FloorBrief
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.place_requests import Sign
from dray.protocol.traffic.driving.right_of_way import IDLE, WITH_TASK, Errand, RightOfWay
from dray.protocol.traffic.driving.wait import ShutOut
from dray.protocol.traffic.surroundings import Surroundings
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.vehicle.drivers.driver import ORDERS_PER_LIFE, Driver, limited_s

LOST = "lost"

FIRST_PACE_FRAC = 0.95
"""Initial pace as a fraction of that on an empty floor: at 85 % load two lanes leave 0.98, a single track 0.92."""

PACE_GAIN = 0.1
"""Weight of the newest leg."""

SLOWEST_PACE_FRAC = 0.2
"""Minimum pace: a slower leg is a fault, not traffic."""


class Owner(Protocol):
    """The vehicle that is driven."""

    id: str
    incarnation: int
    sign_request: Sign

    @property
    def is_busy(self) -> bool:
        """Whether it has a task."""
        ...


class ReservedDriver(Driver):
    """Turns destinations into right of way; the rest of the vehicle need not know of it.

    Args:
        owner: the vehicle.
        plant: its lanes.
        vehicle_type: id of the vehicle's type.
        traffic: the plant's traffic map.
        first_order: first order number of ways and actions.

    Attributes:
        surroundings: known facts about other vehicles.
    """

    def __init__(
        self,
        owner: Owner,
        plant: Plant,
        vehicle_type: str,
        traffic: TrafficMap,
        life: Life,
        *,
        first_order: int,
    ) -> None:
        super().__init__(plant, vehicle_type, life, first_order=first_order)
        self._kind = plant.vehicle_types[vehicle_type]
        self._owner = owner
        self.surroundings = Surroundings(owner.id, traffic.places, Keys(plant.id).floor, life)
        self._traffic = traffic
        self._ways = traffic.ways(vehicle_type)
        self._life = life
        self._is_lost = False
        """Whether the body has lost its way, or has another one than was given."""
        self._right_of_way: RightOfWay | None = None
        self._pace_frac = FIRST_PACE_FRAC
        self._leg: tuple[float, float] | None = None
        """Begin of the present leg, and its duration on an empty floor (s); None for a leg that says nothing about traffic."""

    @property
    def right_of_way(self) -> RightOfWay:
        """The vehicle's right of way.

        Raises:
            ProtocolViolation: if its life has not begun; our own bug.
        """
        if self._right_of_way is None:
            raise ProtocolViolation(f"{self._owner.id} has not been told yet where it stands")
        return self._right_of_way

    # --- as every driver -------------------------------------------------------------------------

    @property
    def pace_frac(self) -> float:
        return self.speed_frac * self._pace_frac

    @property
    def ahead(self) -> tuple[str, ...]:
        return self.right_of_way.way.ahead

    @property
    def next_node(self) -> str:
        if self._right_of_way is None:
            return self.node
        way = self._right_of_way.way
        return way.base[0] if self._is_lost and way.base else way.base_end

    @property
    def next_node_in_m(self) -> float:
        return self.right_of_way.way.base_left_m

    def sense(self, state: VehicleState) -> None:
        super().sense(state)
        row = self._right_of_way
        if row is None:
            return
        stands = state.next_node == state.node and not state.speed_mps
        if stands and state.node not in (row.way.node, *row.way.base):
            self._is_lost = True  # People have carried it here.
        if self._is_lost:
            self._life.alarm(LOST, 0.0)
        elif stands:
            row.sense(0.0 if state.node == row.way.node else row.way.past_m, 0.0)
        elif state.node == row.way.node:
            row.sense(max(self._past_m(state.pose), 1e-6), state.speed_mps)
        self._state = state

    def take_control(self, state: VehicleState, now_s: float) -> None:
        next_node = "" if state.next_node == state.node else state.next_node
        row = self._right_of_way = RightOfWay(
            self._owner.id,
            self._owner.incarnation,
            self._traffic.places,
            self._ways,
            self.surroundings,
            self._life,
            node=state.node,
            next_node=next_node,
            kind=self._kind,
            next_order=self.next_order,
            restrictions=lambda: self._plant.restrictions,
            obstructed=lambda: self._plant.obstructed,
            sign=self._owner.sign_request,
        )
        self.sense(state)
        row.take_control(now_s, drives_beyond=state.base_end not in ("", state.node, next_node))
        if next_node:
            self.way = (next_node,)
            self.arrives_s = now_s + state.next_node_s
        row.start(now_s)

    def go(self, node: str, now_s: float) -> bool:
        row, busy = self.right_of_way, self._owner.is_busy
        if not self.way and row.errand is Errand.OWN and row.stands and row.way.node == node:
            self._stay(now_s)
            return False
        self._mind_closures(row.way.base, now_s)
        way = self._routes.way(self.next_node, node)
        self.way = (node,) if len(way.nodes) < 2 else way.nodes
        self.arrives_s = now_s + limited_s(way.duration_s, self.pace_frac)
        self._leg = (now_s, limited_s(way.duration_s, self.speed_frac)) if way.duration_s else None
        row.go(node, WITH_TASK if busy else IDLE, now_s)
        if row.has_arrived and not row.is_finishing:
            self.way = ()
            self._stay(now_s)
            return False
        return True

    def follow(self, now_s: float) -> bool:
        self._mind_closures(self.right_of_way.way.ahead, now_s)
        if not self.way:
            return super().follow(now_s)
        try:
            self._routes.way(self.next_node, self.right_of_way.goal)
        except NoWay:
            self.halt(now_s)
            return False
        return True

    def on_passed(self, report: NodePassed, now_s: float) -> None:
        self.node = report.node
        spot = self._plant.nodes[report.node]
        self.pose = Pose(x_m=spot.x_m, y_m=spot.y_m, heading_rad=self.pose.heading_rad)
        self.right_of_way.on_reached(report.order, report.index, now_s)

    def on_done(self, report: WayDone, now_s: float) -> bool:
        self.node = report.node
        return self.arrive(now_s)

    def arrive(self, now_s: float) -> bool:
        """Note the arrival; False if it has not arrived, or has noted that before."""
        row = self.right_of_way
        if not self.way or not row.has_arrived or row.is_finishing:
            return False
        self.way, self.speed_mps = (), 0.0
        self._learn(now_s)
        self._stay(now_s)
        return True

    @property
    def goal(self) -> str:
        return self.right_of_way.goal if self._right_of_way is not None else self.node

    def leads_round(self, node: str, now_s: float) -> bool:
        # A way past silent vehicles may cost more than the obstacle does.
        return super().leads_round(node, now_s) and self.right_of_way.leads_round(node, now_s)

    def turn_back(self, node: str, now_s: float, goal: str = "") -> bool:
        row = self.right_of_way
        if row.way.node != node:
            return False
        row.goal = goal or row.goal
        self._is_lost = True
        self._life.alarm(LOST, now_s)
        return True

    def on_failed(self, report: ActionFailed, now_s: float) -> bool:
        """A way was refused or lost: the driver plans anew from the present position."""
        if self.right_of_way.knows(report.order):
            self._is_lost = True
            self._life.alarm(LOST, now_s)
        return False

    def rest(self, now_s: float) -> None:
        if not self.way:
            self.right_of_way.rest(now_s)

    def be_stuck(self, stuck: bool, now_s: float) -> None:
        if self._right_of_way is not None:
            self._right_of_way.be_stuck(stuck, now_s)
        if stuck:
            self._leg = None

    def shut_out_by(self, failed: AtvHeartbeat) -> ShutOut | None:
        return (
            None if failed.floor is UNSET else self.right_of_way.shut_out_by(failed.atv, failed.floor.holds)
        )

    def expect_at(self, place: str, comes_s: float, stays_s: float, *, docked: bool = False) -> None:
        told = DockExpected(place=place, comes_s=comes_s, stays_s=stays_s, docked=docked)
        self._life.publish(Keys(self._plant.id).dock(place), told)

    @property
    def is_placed(self) -> bool:
        return self.right_of_way.is_placed

    def floor(self, now_s: float) -> FloorBrief:
        hint = self.right_of_way.hint(now_s)
        return FloorBrief(
            holds=hint.holds[:HOLDS_MAX],
            stands=hint.stands,
            docked=hint.docked,
            waits=self.right_of_way.is_hindered,
            waits_for=self.right_of_way.wait.by,
            waits_at=self.right_of_way.wait.at,
            rank=hint.rank,
            asks_where_it_stands=not self.is_placed,
            removal=self.right_of_way.removal,
        )

    # --- its own ---------------------------------------------------------------------------------

    def find_way(self, now_s: float) -> None:
        """Handle the alarm `LOST`: the body was just sensed, and a way is given from its position."""
        row = self.right_of_way
        if self._is_lost:
            self._is_lost = False
            state = self._state
            next_node = "" if state.next_node == state.node else state.next_node
            past_m = max(self._past_m(state.pose), 1e-6) if next_node else 0.0
            row.relocate(
                state.node,
                next_node,
                now_s,
                past_m=past_m,
                speed_mps=state.speed_mps,
                drives_beyond=state.base_end not in ("", state.node, next_node),
            )
            self.sense(state)

    def begin_anew(self, now_s: float) -> None:
        """The reservation tables have it as carried away: ask for the place where its body is now."""
        self._is_lost = True
        self._life.alarm(LOST, now_s)

    def _mind_closures(self, nodes: tuple[str, ...], now_s: float) -> None:
        """Plan the way anew from the end of the present lane if lanes behind it were closed or slowed."""
        restrictions = self._plant.restrictions
        if restrictions.limits_on(nodes) or not all(restrictions.admits(*lane) for lane in pairwise(nodes)):
            self._is_lost = True
            self._life.alarm(LOST, now_s)

    def _learn(self, now_s: float) -> None:
        """A leg is over: update the pace from its duration."""
        if self._leg is not None:
            begun_s, alone_s = self._leg
            # Waiting behind vehicles at the dock is counted separately (`dock_queues`).
            took_s = now_s - begun_s - self.right_of_way.wait.at_goal_s
            frac = min(max(alone_s / max(took_s, alone_s), SLOWEST_PACE_FRAC), 1.0)
            self._pace_frac += PACE_GAIN * (frac - self._pace_frac)
            self._leg = None

    def _stay(self, now_s: float) -> None:
        """It has arrived: at a dock with a task no vehicle asks it for room."""
        if self._owner.is_busy and self.right_of_way.way.node in self._traffic.places.docks:
            self.right_of_way.dock(now_s)
        else:
            self.right_of_way.rest(now_s)

    def _past_m(self, pose: Pose) -> float:
        spot = self._plant.nodes[self.node]
        return float(((pose.x_m - spot.x_m) ** 2 + (pose.y_m - spot.y_m) ** 2) ** 0.5)


def driver_of(
    owner: Owner, plant: Plant, vehicle_type: str, traffic: TrafficMap | None, life: Life
) -> Driver:
    """The driver of a vehicle: `ReservedDriver` if there is a traffic map, else `Driver`."""
    first_order = owner.incarnation * ORDERS_PER_LIFE
    if traffic is None:
        return Driver(plant, vehicle_type, life, first_order=first_order)
    return ReservedDriver(owner, plant, vehicle_type, traffic, life, first_order=first_order)
