"""M7 whose goods are on board of ATV2, which lives or has failed."""

from __future__ import annotations

import msgspec
from effects import award_number, published, sent
from m7 import m7
from rigs import MachineRig
from seals import granted
from spoken import accepted, bid, rhb

from dray.messages import (
    Award,
    CommandAnswered,
    CommandRefusal,
    Docked,
    DockOpened,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Phase,
    Role,
    TaskAnnounced,
    TaskBrief,
)
from dray.protocol.liveness.suspicion import LATENESS_MAX_S

GONE_S = LATENESS_MAX_S + 60.0
"""Silence by which any vehicle is given up."""

KIND = MachineCommandKind
NODE = "b2"
"""Where a person hands them over."""

TASK = "M7-1"
PUMPS = 24


def beats(rig: MachineRig, atv: str, seq: int, *, epoch: int = 1, phase: Phase = Phase.CARRYING) -> None:
    said = rhb(atv, seq, rig.now_s, task=TASK, coordinator="M7")
    assert said.task is not None
    brief = msgspec.structs.replace(said.task, epoch=epoch, phase=phase)
    rig.on_message(atv, msgspec.structs.replace(said, task=brief))


def loaded(*, watched: bool = True) -> MachineRig:
    """M7 with a lot of pumps on board of ATV2, which is heard; ATV1 watches."""
    rig = m7(goal=PUMPS)
    rig.cycles(PUMPS)
    assert [each.task for each in published(rig.all, TaskAnnounced)][-1] == TASK
    rig.hire(TASK, "ATV2")
    if watched:
        effects = rig.on_message("ATV1", bid(50.0, task=TASK, role=Role.SECONDARY))
        while not sent(effects, Award, to="ATV1"):
            effects += rig.run(rig.agent.wake_at_s)
        number = award_number(effects, "ATV1", TASK, Role.SECONDARY)
        rig.on_message("ATV1", accepted(TASK, role=Role.SECONDARY, number=number))
    rig.on_message("ATV2", Docked(task=TASK, epoch=1, station="M7"))
    rig.stocked("pump-p3", -PUMPS, "ATV2")
    beats(rig, "ATV2", 1)
    return rig


def stranded(*, watched: bool = True) -> MachineRig:
    """The same, and ATV2 is dead."""
    rig = loaded(watched=watched)
    while told(rig).stranded is msgspec.UNSET:
        run_on(rig, 0.1, watched=watched)
    return rig


def run_on(rig: MachineRig, for_s: float, *, watched: bool = True) -> None:
    """Time passes; ATV1 says that it watches."""
    until_s = rig.now_s + for_s
    while rig.now_s < until_s:
        rig.run(min(rig.now_s + 5.0, until_s))
        if not watched:
            continue
        said = rhb("ATV1", 1 + int(1000 * rig.now_s), rig.now_s, task=TASK, coordinator="M7")
        assert said.task is not None
        watch = msgspec.structs.replace(said.task, role=Role.SECONDARY)
        rig.on_message("ATV1", msgspec.structs.replace(said, task=None, watches=(watch,)))


def told(rig: MachineRig) -> TaskBrief:
    """What its next heartbeat says of it."""
    rig.run(rig.now_s + 1.0)
    [brief] = [each for each in rig.heartbeats(MachineHeartbeat)[-1].tasks if each.task == TASK]
    return brief


def says(
    rig: MachineRig,
    kind: MachineCommandKind,
    *,
    task: str = TASK,
    node: str = "",
    areas: tuple[str, ...] | None = None,
) -> CommandRefusal | None:
    """A person's word; why it was refused."""
    command = MachineCommand(command=f"C{len(rig.all)}", kind=kind, task=task, node=node, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("M7", command, areas=areas)), CommandAnswered)
    assert answer.done == (answer.reason is None)
    return answer.reason


def fetched(rig: MachineRig, *, by: str = "ATV1") -> None:
    """A person hands them over, and a vehicle has them on board."""
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    number = award_number(rig.all, by, TASK)
    rig.on_message(by, accepted(TASK, epoch=2, number=number))
    effects = rig.on_message(by, Docked(task=TASK, epoch=2, station=NODE))
    assert sent(effects, DockOpened, to=by) == [DockOpened(task=TASK, epoch=2, station=NODE)]
    beats(rig, by, 10_000_000, epoch=2)
