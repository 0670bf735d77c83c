"""The machine M7 of the tests, which makes pumps, and what it says."""

from __future__ import annotations

from effects import published, sent
from rigs import BlindRig, MachineRig
from spoken import production

from dray.body import DockReady
from dray.messages import (
    Docked,
    DockOpened,
    Handover,
    MachineHeartbeat,
    MachineStatus,
    Reason,
    Release,
    Role,
    TaskAnnounced,
    Transport,
)
from dray.protocol.runtime.events import Effect

# M7 makes pumps alone: one housing, impeller and seal kit each, 50 s; lots of 24, room for 60.
FULL = {"housing": 72, "impeller": 90, "seal-kit": 120}
NO_HOUSINGS = FULL | {"housing": 0}

RELEASE = Release(task="G1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1)


def m7(stock: dict[str, int] = FULL, *, goal: int = 0) -> MachineRig:
    """M7, started, with a goal of that many pumps unless none."""
    rig = MachineRig("M7", stock)
    rig.start()
    if goal:
        rig.take_goal("G1", production(quantity=goal))
    return rig


def transports(effects: list[Effect]) -> list[Transport]:
    """The work of all transports that were announced for the first time."""
    return [
        message.work
        for message in published(effects, TaskAnnounced)
        if message.round == 1 and message.role is Role.PRIMARY and isinstance(message.work, Transport)
    ]


def incoming(effects: list[Effect]) -> list[tuple[str, int]]:
    return [(work.item, work.quantity) for work in transports(effects) if not work.goal]


def outgoing(effects: list[Effect]) -> list[tuple[str, int]]:
    return [(work.goal, work.quantity) for work in transports(effects) if work.goal]


def status(rig: MachineRig) -> MachineStatus:
    return rig.heartbeats(MachineHeartbeat)[-1].status


def docked(task: str = "M7-1", epoch: int = 1, station: str = "M7") -> Docked:
    return Docked(task=task, epoch=epoch, station=station)


def handover(task: str = "M7-1", epoch: int = 1, quantity: int = 24) -> Handover:
    return Handover(task=task, epoch=epoch, quantity=quantity)


def supplied_by(atv: str = "ATV2", stock: dict[str, int] = NO_HOUSINGS) -> MachineRig:
    """M7 without housings; a vehicle is contracted to bring some (M7-1)."""
    return hiring(MachineRig("M7", stock), atv)


def hiring(rig: MachineRig, atv: str = "ATV2", *, goal: int = 24, answers: bool = False) -> MachineRig:
    """Start M7 with a goal; a vehicle is contracted to bring what it lacks (M7-1). With `answers` its dock makes itself safe."""
    rig.answers = answers
    rig.start()
    rig.take_goal("G1", production(quantity=goal))
    rig.hire("M7-1", atv)
    return rig


def unloading(rig: MachineRig | None = None) -> MachineRig:
    """M7, whose dock makes itself safe and whose body does not count; ATV2 unloads 24 housings there (M7-1)."""
    rig = hiring(rig or BlindRig("M7", NO_HOUSINGS), answers=True)
    rig.on_message("ATV2", docked())
    assert sent(rig.report(DockReady(vehicle="ATV2")), DockOpened)
    return rig


def delivered(rig: MachineRig, task: str) -> list[Effect]:
    """A vehicle carries a lot of goods away."""
    rig.hire(task, "ATV2")
    [work] = [each.work for each in published(rig.all, TaskAnnounced) if each.task == task][:1]
    rig.stocked("pump-p3", -work.quantity, "ATV2")  # type: ignore[union-attr]
    return rig.on_message("ATV2", handover(task, quantity=work.quantity))  # type: ignore[union-attr]


def counted(rig: MachineRig) -> list[tuple[str, int, int]]:
    """What the next heartbeat says of goals: name, made, delivered."""
    rig.run(rig.now_s + 5.0)
    return [(brief.goal, brief.made, brief.delivered) for brief in rig.heartbeats(MachineHeartbeat)[-1].goals]
