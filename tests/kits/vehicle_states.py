"""States of a vehicle, as its body senses them."""

from __future__ import annotations

from typing import Any

from dray.body import VehicleState
from dray.messages import Pose
from dray.plant import Plant


def standing(plant: Plant, node: str, **fields: Any) -> VehicleState:
    """A vehicle that stands at a node with nothing on board; `fields` may change anything."""
    spot = plant.nodes[node]
    usual: dict[str, Any] = {
        "pose": Pose(x_m=spot.x_m, y_m=spot.y_m, heading_rad=0.0),
        "node": node,
        "next_node": node,
        "next_node_s": 0.0,
        "speed_mps": 0.0,
        "battery_frac": 0.9,
        "load": "",
        "load_quantity": 0,
        "held": False,
        "charging": False,
    }
    return VehicleState(**usual | fields)
