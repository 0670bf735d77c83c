"""A machine that comes to a plant whose file does not know it."""

from __future__ import annotations

from typing import Any

from fake_bus import PLANT
from heartbeats import machine_heartbeat
from msgspec.structs import replace

from dray.messages import JoiningMachine, MachineHeartbeat
from dray.messages.heartbeat import Making
from dray.plant import MachineSpec, Plant

SPEC = Plant(PLANT).machines["M3"]
BEFORE = replace(PLANT, machines=tuple(spec for spec in PLANT.machines if spec.id != SPEC.id))


def introduction(machine: str = SPEC.id, seq: int = 1, **fields: Any) -> MachineHeartbeat:
    return introduction_of(SPEC, machine, seq, **fields)


def introduction_of(spec: MachineSpec, machine: str = "", seq: int = 1, **fields: Any) -> MachineHeartbeat:
    """What a machine says that has this entry in its own plant file."""
    joining = JoiningMachine(
        name=spec.name,
        station=spec.station,
        node=spec.node,
        x_m=spec.box.x_m,
        y_m=spec.box.y_m,
        width_m=spec.box.width_m,
        depth_m=spec.box.depth_m,
        makes=tuple(Making(making.product, making.cycle_s) for making in spec.makes),
        goods_capacity=spec.goods_capacity,
    )
    return machine_heartbeat(machine or spec.id, seq, joining=replace(joining, **fields))
