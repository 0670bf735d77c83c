"""Heartbeats and facts, as agents publish them."""

from __future__ import annotations

from typing import Any

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Event,
    MachineHeartbeat,
    MachineStatus,
    Pose,
    StationHeartbeat,
)
from dray.messages.fact import AnyFact


def atv_heartbeat(atv: str = "ATV1", seq: int = 1, **fields: Any) -> AtvHeartbeat:
    """A vehicle that stands somewhere; `fields` may change anything."""
    usual: dict[str, Any] = {
        "incarnation": 1,
        "at_s": float(seq),
        "status": AtvStatus.IDLE,
        "pose": Pose(1.0, 2.0, 0.0),
        "node": "n1",
        "speed_mps": 0.0,
        "battery_frac": 0.8,
    }
    return AtvHeartbeat(atv=atv, seq=seq, **usual | fields)


def machine_heartbeat(machine: str = "M1", seq: int = 1, **fields: Any) -> MachineHeartbeat:
    """A machine with nothing to do; `fields` may change anything."""
    usual: dict[str, Any] = {"incarnation": 1, "at_s": float(seq), "status": MachineStatus.IDLE}
    return MachineHeartbeat(machine=machine, seq=seq, **usual | fields)


def station_heartbeat(station: str = "S1", seq: int = 1, **fields: Any) -> StationHeartbeat:
    """The station of a storage, which tells nothing of what lies there; `fields` may change anything."""
    usual: dict[str, Any] = {"incarnation": 1, "at_s": float(seq)}
    return StationHeartbeat(station=station, seq=seq, **usual | fields)


def events(agent: str, *facts: AnyFact, life: int = 1, first: int = 1, at_s: float = 100.0) -> list[Event]:
    """An agent's numbered facts, one second apart."""
    return [
        Event(agent=agent, incarnation=life, number=number, at_s=at_s + number, fact=fact)
        for number, fact in enumerate(facts, first)
    ]
