"""The vehicle ATV1 of the tests, at its stages."""

from __future__ import annotations

from effects import facts, sent
from rigs import VehicleRig
from seals import granted
from spoken import award

from dray.messages import AtvHeartbeat, CommandAnswered, CommandKind, DockOpened, Role, VehicleCommand
from dray.messages.fact import CommandObeyed
from dray.protocol.runtime.events import Effect

SETTLED_S = 7.0
"""By then ATV1 has looked for a place after it was switched on, and CONTEST_S have not passed yet."""


def parked(**options: object) -> VehicleRig:
    """ATV1 at parking place P3, started."""
    rig = VehicleRig(**options)  # type: ignore[arg-type]
    rig.start()
    return rig


def contracted(**options: object) -> VehicleRig:
    """ATV1 as the primary of M8-1, on its way to S3."""
    rig = parked(**options)
    rig.on_message("M8", award())
    return rig


def unloading() -> VehicleRig:
    """ATV1 with its load, asking M8 for its dock."""
    rig = contracted()
    rig.arrive()
    rig.picked()
    rig.arrive()
    return rig


def handing_over() -> VehicleRig:
    rig = unloading()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    return rig


def secondary(rig: VehicleRig, task: str = "M8-2", primary: str = "ATV2") -> list[Effect]:
    """ATV1 is asked to watch a task of M8."""
    return rig.on_message("M8", award(task=task, role=Role.SECONDARY, primary=primary))


def command(
    rig: VehicleRig, kind: CommandKind, speed_frac: float | None = None, *, name: str = ""
) -> CommandAnswered:
    """Give a command; a new one unless it is given the name of one before."""
    name = name or f"C{len(facts(rig.all, CommandObeyed)) + 1}"
    message = VehicleCommand(command=name, kind=kind, speed_frac=speed_frac, issued_by="shift lead")
    [answer] = sent(rig.on_message("gateway", granted("ATV1", message)), CommandAnswered, to="gateway")
    return answer


def last_beat(rig: VehicleRig) -> AtvHeartbeat:
    """The heartbeat that is due now, if one is; else the newest."""
    rig.run(rig.now_s)
    return rig.heartbeats(AtvHeartbeat)[-1]
