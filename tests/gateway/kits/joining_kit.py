"""A machine that comes to a plant whose file does not know it."""

from __future__ import annotations

from typing import Any

from fake_bus import PLANT
from heartbeats import machine_heartbeat
from msgspec.structs import replace

from dray.messages import JoiningMachine, MachineHeartbeat
from dray.messages.heartbeat import Making
from dray.plant import Plant

SPEC = Plant(PLANT).machines["M3"]
BEFORE = replace(PLANT, machines=tuple(spec for spec in PLANT.machines if spec.id != SPEC.id))


def introduction(machine: str = SPEC.id, seq: int = 1, **fields: Any) -> MachineHeartbeat:
    joining = JoiningMachine(
        name=SPEC.name,
        station=SPEC.station,
        node=SPEC.node,
        x_m=SPEC.box.x_m,
        y_m=SPEC.box.y_m,
        width_m=SPEC.box.width_m,
        depth_m=SPEC.box.depth_m,
        makes=tuple(Making(making.product, making.cycle_s) for making in SPEC.makes),
        goods_capacity=SPEC.goods_capacity,
    )
    return machine_heartbeat(machine, seq, joining=replace(joining, **fields))
