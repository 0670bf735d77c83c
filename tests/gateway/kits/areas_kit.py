"""A plant in which something goes on in every area, and every word that only one area may hear is known.

In each area of the default plant a vehicle stands, which carries for a machine there, is watched by the
vehicle of the next area, and has taken its task over from that one.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import Any

import pytest
from heartbeats import atv_heartbeat, events, machine_heartbeat

from dray.messages import (
    AtvStatus,
    BodyWait,
    Brief,
    BufferLevel,
    Event,
    GoalBrief,
    HelpWanted,
    Link,
    Message,
    Phase,
    Pose,
    Reason,
    Role,
    TaskBrief,
    Transport,
    TransportCost,
)
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    AwardGiven,
    BidReceived,
    CarrierChanged,
    GoalWaits,
    HelpAsked,
    LinkChanged,
    MachineFailure,
    TaskOpened,
)
from dray.messages.floor.traffic import HOLDS_MAX
from dray.messages.heartbeat import FloorBrief
from dray.plant import load_plant

FLOOR = load_plant("single-track")

AREAS = tuple(FLOOR.areas)

MACHINE = {
    area: next(m for m in FLOOR.machines if area in FLOOR.areas_at(*FLOOR.position_of(m))) for area in AREAS
}

STORAGE = {
    area: next(s for s in FLOOR.storages if area in FLOOR.areas_at(*FLOOR.position_of(s))) for area in AREAS
}

NODE = {area: FLOOR.node_of(machine) for area, machine in MACHINE.items()}

ATV = {area: f"ATV{number}" for number, area in enumerate(AREAS, 1)}

TASK = {area: f"{machine}-77" for area, machine in MACHINE.items()}

GOAL, ORDER, PRICE_S = "O-4711.1", "O-4711", 41.375
"""What no operator hears of."""


def middle(area: str) -> tuple[float, float]:
    """A point that lies in this area alone."""
    corners = FLOOR.areas[area].polygon
    count = len(corners)
    return sum(corner.x_m for corner in corners) / count, sum(corner.y_m for corner in corners) / count


def after(area: str) -> str:
    """The next area, in a ring."""
    return AREAS[(AREAS.index(area) + 1) % len(AREAS)]


def standing(area: str, where: str = "", *, seq: int = 1) -> Message:
    """The heartbeat of an area's vehicle: in its own area or in another one."""
    x_m, y_m = middle(where or area)
    return atv_heartbeat(
        ATV[area],
        seq,
        status=AtvStatus.WORKING,
        pose=Pose(x_m, y_m, 0.0),
        link=Link.MESH,
        via=(ATV[after(area)],),
        way=tuple(FLOOR.nodes),
        task=_brief(area, Role.PRIMARY),
        watches=(_brief(after(area), Role.SECONDARY),),
        help=HelpWanted(until_s=500.0),
        problem=f"the way is blocked by {ATV[after(area)]}",
        body_wait=BodyWait(
            what=f"{ATV[after(area)]} is in its way", since_s=1.0, until=f"{ATV[after(area)]} is gone"
        ),
        dwell_point=next(iter(FLOOR.dwell_points)),
        floor=FloorBrief(
            holds=tuple(FLOOR.nodes)[:HOLDS_MAX], waits=True, waits_for=ATV[after(area)], waits_at=NODE[area]
        ),
    )


def _brief(area: str, role: Role) -> Brief:
    return Brief(
        task=TASK[area], epoch=2, role=role, coordinator=MACHINE[area], phase=Phase.CARRYING, item="shaft"
    )


def making(area: str, *, seq: int = 1) -> Message:
    """The heartbeat of an area's machine."""
    task = TaskBrief(
        task=TASK[area],
        epoch=2,
        item="shaft",
        quantity=5,
        source=STORAGE[area],
        destination=MACHINE[area],
        deadline_s=900.0,
        primary=ATV[area],
        secondary=ATV[after(area)],
        trouble=Reason.PROBLEM,
        detail=f"{ATV[area]} waits for {ATV[after(area)]}.",
    )
    goal = GoalBrief(goal=GOAL, product="pump-p3", quantity=7, made=2, delivered=1)
    level = BufferLevel(item="shaft", level=3, capacity=9)
    return machine_heartbeat(MACHINE[area], seq, goals=(goal,), tasks=(task,), buffers=(level,))


def happening(area: str) -> Iterable[Event]:
    """What has happened to an area's task and vehicle."""
    task, machine, atv, other = TASK[area], MACHINE[area], ATV[area], ATV[after(area)]
    work = Transport(
        item="shaft", quantity=5, sources=(STORAGE[area],), destination=machine, ability="tote", goal=GOAL
    )
    cost = TransportCost(empty_way_s=PRICE_S, loaded_way_s=1.0, energy_s=1.0, suitability_s=0.0)
    primary = Role.PRIMARY
    told: list[AnyFact] = [
        TaskOpened(task, 1, primary, 1, work, 20.0, 900.0, 2.0),
        *(
            BidReceived(task, 1, primary, 1, each, cost, PRICE_S + 2.0, 90.0, STORAGE[area])
            for each in (atv, other)
        ),
        AwardGiven(task, 1, primary, other, 1),
        AwardAnswered(task, 1, primary, other, "accepted"),
        CarrierChanged(task, 2, other, atv, Reason.SILENT, 4.0),
    ]
    yield from events(machine, *told)
    yield from events(atv, HelpAsked(task, f"blocked by {other}", 500.0), LinkChanged(Link.MESH))


def orders_wait() -> Iterable[Event]:
    """The strategist cannot give a goal out."""
    yield from events("strategist", GoalWaits(GOAL, ORDER, (MachineFailure("M1", Reason.SILENT),)))


def told_of(area: str) -> list[Message]:
    """All that goes on in one area."""
    return [making(area), standing(area), *happening(area)]


def everything() -> list[Message]:
    """All that goes on in the plant."""
    return [*(message for area in AREAS for message in told_of(area)), *orders_wait()]


def words(said: Any) -> set[str]:
    """Every word in an answer or a frame."""
    return set(re.findall(r"[\w-]+(?:\.\w+)*", said if isinstance(said, str) else json.dumps(said)))


def secrets_of(area: str) -> set[str]:
    """Words that nobody may hear who sees this area only."""
    vehicles = {ATV[other] for other in AREAS if other != area} | set(FLOOR.fleet) - {ATV[area]}
    # The next area's vehicle is watched from here; that is all that is told of it, and not which one.
    tasks = {TASK[other] for other in AREAS if other != area}
    return vehicles | tasks | {GOAL, ORDER, str(PRICE_S), "Muster"}


every_area = pytest.mark.parametrize("area", AREAS)
