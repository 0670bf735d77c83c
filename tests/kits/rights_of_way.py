"""The right of way of one vehicle, as its agent makes it, without the agent."""

from __future__ import annotations

from itertools import count

from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.right_of_way import RightOfWay
from dray.protocol.traffic.surroundings import Surroundings
from dray.protocol.traffic.traffic_map import TrafficMap


def surroundings_of(plant: Plant, traffic: TrafficMap, life: Life, atv: str = "A") -> Surroundings:
    """What that vehicle knows of others: nothing yet."""
    return Surroundings(atv, traffic.places, Keys(plant.id).floor, life)


def right_of_way(
    plant: Plant,
    traffic: TrafficMap,
    life: Life,
    node: str,
    next_node: str = "",
    *,
    atv: str = "A",
    incarnation: int = 1,
    surroundings: Surroundings | None = None,
) -> RightOfWay:
    """The right of way of a vehicle of the type of the plant's first one, not started yet."""
    type_ = next(iter(plant.fleet.values())).type
    return RightOfWay(
        atv,
        incarnation,
        traffic.places,
        traffic.ways(type_),
        surroundings or surroundings_of(plant, traffic, life, atv),
        life,
        node=node,
        next_node=next_node,
        kind=plant.vehicle_types[type_],
        next_order=count(1).__next__,
    )
