"""A vehicle that watches another one, one that carries, and one that was started again, for tests of takeovers."""

from __future__ import annotations

import msgspec
from effects import committed, sent
from rigs import VehicleRig
from spoken import award, rhb, transport

from dray.messages import (
    AtvHeartbeat,
    Brief,
    Phase,
    Role,
    TakenOver,
)
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray.protocol.runtime.events import Started

BOUND_S = bound_s(WORKING_INTERVAL_S)

GOODS = transport(item="pump-p3", quantity=24, sources=("M8",), destination="DELIVERY", goal="G8")


def beat(rig: VehicleRig, seq: int, *, phase: Phase = Phase.APPROACHING, **changes: object) -> None:
    """ATV2, the primary of M8-1, is heard now."""
    brief = Brief(task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8", phase=phase)
    heartbeat = msgspec.structs.replace(rhb("ATV2", seq, rig.now_s, task="M8-1"), task=brief)
    rig.on_message("ATV2", msgspec.structs.replace(heartbeat, **changes))


def guard(**changes: object) -> VehicleRig:
    """ATV1, which watches ATV2 carrying M8-1, and has just heard of it."""
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2", **changes))
    beat(rig, 1)
    return rig


def claims(rig: VehicleRig) -> list[TakenOver]:
    return sent(rig.all, TakenOver, to="M8")


def carrying() -> VehicleRig:
    """ATV1 as the primary of M8-1, due well before its deadline."""
    rig = VehicleRig()
    rig.start()
    rig.on_message("M8", award(deadline_s=3600.0))
    return rig


def newest(rig: VehicleRig) -> AtvHeartbeat:
    rig.run(rig.now_s)
    return rig.heartbeats(AtvHeartbeat)[-1]


def reborn(rig: VehicleRig) -> VehicleRig:
    """The same vehicle after a restart of its software."""
    again = VehicleRig(node=rig.node, battery_frac=rig.battery_frac)
    again.load, again.held, again.now_s = rig.load, rig.held, rig.now_s
    again.handle(Started(again.sense(), committed(rig.all)))
    return again
