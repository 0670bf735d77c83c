"""Building orders: the next step of a way, more of its base, an action where the vehicle stands."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise

from dray.adapters.vda5050.control.names import Names
from dray.adapters.vda5050.control.vehicle_order import Kind, Place, Stop, Task, VehicleOrder
from dray.adapters.vda5050.control.view import VehicleView
from dray.adapters.vda5050.control.way import Way, length_m
from dray.adapters.vda5050.control.whereabouts import Stand
from dray.adapters.vda5050.profile import ActionUse, Profile
from dray.adapters.vda5050.wire.orders import Action, Spot
from dray.body import Charge, Drop, Pick
from dray.plant import Plant
from dray.plant.model import MapFrame, VehicleType

TEMPORARY = "here"
"""The name of a node outside the plant, for a vehicle that stands between two nodes."""


@dataclass(frozen=True)
class More:
    """The content of an update."""

    stops: list[Stop]
    places: list[Place]
    speeds_mps: list[float | None]
    """The limits of base and horizon."""
    beyond: list[Stop]


class Steps:
    """Builds orders for one vehicle.

    Args:
        plant: roads and stations.
        vehicle_type: its speed.
        profile: its type's profile.
        view: its position.

    Attributes:
        twice: whether an action's node is listed twice, with sequence 0 and 2.
    """

    def __init__(self, plant: Plant, vehicle_type: VehicleType, profile: Profile, view: VehicleView) -> None:
        self._plant, self._type, self._profile, self._view = plant, vehicle_type, profile, view
        self.twice = profile.action_node_twice
        self._lane_of = {corner: ends for ends, chain in plant.corners.items() for corner in chain}

    @property
    def corners(self) -> Collection[str]:
        """Nodes that vehicles do not know: the corners of lanes that are not straight."""
        return self._lane_of.keys()

    def spot(self, node: str) -> Spot:
        """A node's position in the vehicle's map."""
        point = self._plant.nodes[node]
        map_id = self._view.names.map_of(node, self._view.map_id)
        return self._spot_at(point.x_m, point.y_m, self._profile.deviation_m, map_id)

    def next(self, way: Way, stand: Stand, speed_frac: float) -> VehicleOrder | str:
        """The next step of a way.

        Args:
            way: a way with released nodes ahead.
            stand: the vehicle's position.
            speed_frac: the limit that people have set.

        Returns:
            An order, or the reason why there is none.
        """
        first = self._start(stand)
        due = way.nodes[way.passed + 1]
        here = way.nodes[way.passed] if way.passed >= 0 else ""
        if stand.ahead and stand.ahead != due:
            return f"the way must begin at {stand.ahead}"
        if not stand.ahead and stand.node != here:
            return f"the way must begin at {stand.node}"
        end = way.reach(self._plant, way.passed, self._profile.base_m)
        indexes = range(way.passed + 1, end + 1)
        if first[0] != stand.node and first[0] in way.nodes[way.passed + 1 : end + 1]:
            first = TEMPORARY, first[1]  # It turns back on its lane: the node is ahead.
        order = VehicleOrder(
            Kind.STEP,
            way.number,
            [first, *((way.nodes[i], self.spot(way.nodes[i])) for i in indexes)],
            self._beyond(way, end),
            [None, *self._speeds(way, way.passed + 1, end, speed_frac)],
            corners=self.corners,
        )
        order.origin = stand.node
        order.places = [None, *((way.number, i) for i in indexes)]
        order.takes_updates = self._profile.updates
        return order

    def more(self, order: VehicleOrder, way: Way | None, speed_frac: float) -> More | None:
        """The next extension of a running order; None for none."""
        if not order.takes_updates:
            return None
        place = order.places[order.end]
        if way is None or place is None or place[0] != way.number:
            # The rest belongs to another way: only the horizon can be withdrawn.
            return More([], [], [], []) if order.beyond else None
        index = place[1]
        # The remaining distance counts: a base that is long enough stays as it is.
        left_m = self._left_m(order)
        end = index
        most = way.drivable
        while end + 1 < most and (left_m <= self._profile.base_m or way.nodes[end] in self._lane_of):
            left_m += length_m(self._plant, way.nodes[end], way.nodes[end + 1])
            end += 1
        beyond = self._beyond(way, end)
        told = tuple(stop[0] for stop in order.beyond)
        is_stale = told != tuple(stop[0] for stop in beyond)[: len(told)]
        if end == index and not is_stale:
            return None
        indexes = range(index + 1, end + 1)
        return More(
            [(way.nodes[i], self.spot(way.nodes[i])) for i in indexes],
            [(way.number, i) for i in indexes],
            self._speeds(way, index + 1, end, speed_frac),
            beyond,
        )

    def action(self, task: Task, node: str, *, twice: bool | None = None) -> VehicleOrder:
        """An order for a task where the vehicle stands: its node once, or twice for vehicles that need a way to it."""
        twice = self.twice if twice is None else twice
        use, values = self._use(task), _values(task, node, self._view.names)
        action = Action("", use.type, use.blocking, use.values(**values))
        stop = self._start(Stand(node))
        stops = [stop, (node, self.spot(node))] if twice else [stop]
        kind = {Pick: Kind.PICK, Drop: Kind.DROP, Charge: Kind.CHARGE}[type(task)]
        order = VehicleOrder(kind, task.order, stops, [], [None] * len(stops), action, task)
        order.is_twice, order.takes_updates = twice, False
        if self._is_by_hand(task):
            order.by_hand_s = self._profile.by_hand_s
        return order

    def place(self, way: Way, order: VehicleOrder | None) -> None:
        """Count the rest of the present order's base as nodes of a new way, if the way begins with all of them.

        Else none counts: a passed node would tell its agent that the vehicle follows the new way, and it drives to the end of its base.
        """
        if order is None or order.kind is not Kind.STEP:
            return
        if order.passed == order.end:
            order.places[order.end] = (way.number, 0)  # It waits there for more.
            return
        first = order.passed + 1
        rest = order.nodes[first:]
        agrees = way.nodes[: len(rest)] == rest
        order.places[first:] = [(way.number, index) if agrees else None for index in range(len(rest))]
        if agrees:
            way.released = max(way.released, len(rest))  # The base cannot be withdrawn.

    def _start(self, stand: Stand) -> Stop:
        """The first node of an order: the vehicle's present position."""
        point, wide_m = self._plant.nodes[stand.node], self._profile.first_deviation_m
        pose, lane = self._view.pose, self._lane_of.get(stand.node)
        if lane is None and (not stand.ahead or pose is None):
            map_id = self._view.names.map_of(stand.node, self._view.map_id)
            return stand.node, self._spot_at(point.x_m, point.y_m, wide_m, map_id)
        name = stand.node if self._profile.restart_at == "last_node" else TEMPORARY
        if lane is not None and name != TEMPORARY:
            said = self._view.state.last_node_id
            name = said if said in lane else lane[0]
        x_m, y_m = (point.x_m, point.y_m) if pose is None else (pose.x_m, pose.y_m)
        return name, self._spot_at(x_m, y_m, wide_m, self._view.map_id)

    def _spot_at(self, x_m: float, y_m: float, wide_m: float, map_id: str) -> Spot:
        frame = self._view.names.frame(map_id) or MapFrame()
        x, y = frame.to_map(x_m, y_m)
        return Spot(x=x, y=y, map_id=map_id, deviation=wide_m / frame.scale)

    def _beyond(self, way: Way, end: int) -> list[Stop]:
        told = self._profile.horizon if self._profile.updates else 0
        nodes = [index for index in range(end + 1, len(way.nodes)) if way.nodes[index] not in self._lane_of]
        last = nodes[:told][-1] if nodes[:told] else end
        return [(node, self.spot(node)) for node in way.nodes[end + 1 : last + 1]]

    def _speeds(self, way: Way, first: int, end: int, speed_frac: float) -> list[float | None]:
        """The limits on the lanes to these nodes of a way, and on those of its horizon."""
        last = end + len(self._beyond(way, end))
        return [way.speed_mps(self._plant, i, self._type, speed_frac) for i in range(first, last + 1)]

    def _left_m(self, order: VehicleOrder) -> float:
        """A lower bound of the remaining distance on its base."""
        nodes = order.nodes[order.passed :]
        left_m = sum(length_m(self._plant, *pair) for pair in pairwise(nodes))
        pose = self._view.pose
        if pose is None or len(nodes) < 2:
            return left_m
        spot = self._plant.nodes.get(nodes[0])
        if spot is None:
            return left_m
        return max(left_m - float(((spot.x_m - pose.x_m) ** 2 + (spot.y_m - pose.y_m) ** 2) ** 0.5), 0.0)

    def _is_by_hand(self, task: Task) -> bool:
        """Whether a person hands the load over, without a station."""
        return isinstance(task, Pick) and task.station not in self._plant.places

    def _use(self, task: Task) -> ActionUse:
        match task:
            case Pick():
                return self._profile.pick_by_hand if self._is_by_hand(task) else self._profile.pick
            case Drop():
                return self._profile.drop
        return self._profile.charge


def _values(task: Task, node: str, names: Names) -> dict[str, str | int]:
    """The values for names in a profile's parameters."""
    return {
        "station": names.station(task.charger if isinstance(task, Charge) else task.station),
        "node": names.node(node),
        "item": task.item if isinstance(task, Pick) else "",
        "quantity": task.quantity if isinstance(task, Pick) else 0,
        "goal": task.goal if isinstance(task, Drop) else "",
    }
