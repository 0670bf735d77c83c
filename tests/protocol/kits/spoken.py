"""What agents say to each other in tests, with usual values."""

from __future__ import annotations

from typing import Any

import msgspec
from defaults import PLANT, SOME_TIME_S
from makings import making

from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    Award,
    Bid,
    Brief,
    Declined,
    GoalBrief,
    MachineHeartbeat,
    MachineStatus,
    Pose,
    Production,
    ProductionCost,
    Refusal,
    Role,
    TaskAnnounced,
    Transport,
    TransportCost,
)


def transport(**changes: Any) -> Transport:
    """Forty shafts from S3 to M8, unless told otherwise."""
    work = Transport(item="shaft", quantity=40, sources=("S3",), destination="M8", ability="tote")
    return msgspec.structs.replace(work, **changes)


def production(**changes: Any) -> Production:
    """A lot of pumps for order O1, unless told otherwise."""
    work = making(changes.get("product", "pump-p3"), 24, "O1", plant=PLANT)
    return msgspec.structs.replace(work, **changes)


def announcement(**changes: Any) -> TaskAnnounced:
    """M8 asks the whole plant for a carrier of `transport()`, unless told otherwise."""
    x_m, y_m = PLANT.position_of("M8")
    message = TaskAnnounced(
        task="M8-1",
        epoch=1,
        role=Role.PRIMARY,
        coordinator="M8",
        work=transport(),
        deadline_s=3600.0,
        x_m=x_m,
        y_m=y_m,
        radius_m=PLANT.diameter_m,
    )
    return msgspec.structs.replace(message, **changes)


def award(**changes: Any) -> Award:
    """M8 awards M8-1 to a primary, unless told otherwise."""
    message = Award(task="M8-1", epoch=1, role=Role.PRIMARY, work=transport(), deadline_s=3600.0)
    return msgspec.structs.replace(message, **changes)


def bid(
    cost_s: float,
    *,
    task: str = "T1",
    epoch: int = 1,
    role: Role = Role.PRIMARY,
    round: int = 1,  # noqa: A002
    finish_s: float = SOME_TIME_S,
    source: str = "S3",
) -> Bid:
    """A bid for a transport at a price, all of it for the loaded way."""
    cost = TransportCost(empty_way_s=0.0, loaded_way_s=cost_s, energy_s=0.0, suitability_s=0.0)
    return Bid(task=task, epoch=epoch, role=role, round=round, cost=cost, finish_s=finish_s, source=source)


def goal_bid(goal: str, cost_s: float, *, epoch: int = 1) -> Bid:
    """A machine's bid for a goal at a price."""
    cost = ProductionCost(queue_s=0.0, material_s=0.0, making_s=cost_s)
    return Bid(task=goal, epoch=epoch, role=Role.PRIMARY, round=1, cost=cost, finish_s=SOME_TIME_S)


def accepted(task: str = "T1", *, epoch: int = 1, role: Role = Role.PRIMARY, number: int = 1) -> Accepted:
    return Accepted(task=task, epoch=epoch, role=role, finish_s=100.0, number=number)


def declined(
    task: str = "T1",
    *,
    epoch: int = 1,
    role: Role = Role.PRIMARY,
    reason: Refusal = Refusal.BUSY,
    number: int = 1,
) -> Declined:
    return Declined(task=task, epoch=epoch, role=role, reason=reason, number=number)


def rhb(atv: str, seq: int, at_s: float, *, task: str = "", coordinator: str = "M8") -> AtvHeartbeat:
    """A vehicle's heartbeat: working at a task, or idle."""
    brief = Brief(task=task, epoch=1, role=Role.PRIMARY, coordinator=coordinator) if task else None
    return AtvHeartbeat(
        atv=atv,
        incarnation=1,
        seq=seq,
        at_s=at_s,
        status=AtvStatus.WORKING if task else AtvStatus.IDLE,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="a1",
        speed_mps=0.0,
        battery_frac=0.9,
        task=brief,
    )


def mhb(machine: str, *goals: GoalBrief, seq: int = 1, at_s: float = 0.0) -> MachineHeartbeat:
    """A machine's heartbeat that tells of its goals."""
    return MachineHeartbeat(
        machine=machine, incarnation=1, seq=seq, at_s=at_s, status=MachineStatus.PRODUCING, goals=goals
    )
