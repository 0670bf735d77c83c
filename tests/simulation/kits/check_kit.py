"""What agents say in a run of task M8-1, for tests."""

from __future__ import annotations

from dray.messages import AtvHeartbeat, AtvStatus, Brief, Event, Pose, Production, Role, Transport
from dray.messages.fact import Fact, TaskClosed, TaskOpened
from dray.plant import load_plant

PLANT = load_plant("single-track")
WORK = Transport(item="shaft", quantity=40, sources=("S3",), destination="M8", ability="tote")
TASK = "M8-1"


def event(agent: str, fact: Fact) -> Event:
    return Event(agent=agent, incarnation=1, number=1, at_s=0.0, fact=fact)


def opened(task: str = TASK, work: Transport | Production = WORK) -> TaskOpened:
    return TaskOpened(
        task=task,
        epoch=1,
        role=Role.PRIMARY,
        round=1,
        work=work,
        radius_m=25.0,
        deadline_s=100.0,
        bids_until_s=1.0,
    )


def closed(task: str = TASK) -> TaskClosed:
    return TaskClosed(task=task, epoch=1, outcome="delivered", carrier="ATV2")


def heartbeat(atv: str, task: str = "") -> AtvHeartbeat:
    brief = Brief(task=task, epoch=1, role=Role.PRIMARY, coordinator="M8") if task else None
    return AtvHeartbeat(
        atv=atv,
        incarnation=1,
        seq=1,
        at_s=0.0,
        status=AtvStatus.IDLE,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="a1",
        speed_mps=0.0,
        battery_frac=1.0,
        task=brief,
    )
