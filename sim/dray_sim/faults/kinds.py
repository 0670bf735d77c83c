"""The kinds of faults: each is a value that says what is wrong, not when.

Network faults are data of the network (`dray_sim.network.faults`); this module has those of power, processes and
bodies.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, get_args

from msgspec import Meta

from dray.messages import NOTHING_KNOWN, Problem
from dray.messages.base import Count, Id, Text
from dray_sim.network.faults import FaultKind, NetworkFault, snake

# --- power and processes ---------------------------------------------------------------------------


class PoweredOff(FaultKind, frozen=True):
    """A vehicle or a machine is without power: body and agent together."""

    agent: Id


class Crashed(FaultKind, frozen=True):
    """An agent's process has ended; its body goes on as bodies do. The process is started again at the end."""

    agent: Id


class JournalLost(FaultKind, frozen=True):
    """An agent's process has ended, and its journal is lost or torn: the next life starts without memory."""

    agent: Id


class ClockSet(FaultKind, frozen=True):
    """The clock of an agent's computer was set forward or back; at the end it is set right."""

    agent: Id
    by_s: Annotated[float, Meta(ge=-3600.0, le=3600.0)]


class SentAway(FaultKind, frozen=True):
    """An agent was asked to shut down gracefully, for other software say; it is started again at the end.

    An agent that has not left by then is killed.
    """

    agent: Id
    probation: Count = 0
    """Transports that its next life has to do well before it takes long tasks."""


# --- bodies ----------------------------------------------------------------------------------------


class MachineBroken(FaultKind, frozen=True):
    """A machine stands, and its agent can say so."""

    machine: Id
    reason: Text = "a tool has broken"
    problem: Problem = NOTHING_KNOWN
    """Details that its body knows."""


class VehicleBroken(FaultKind, frozen=True):
    """A vehicle has a problem (paper, case 4)."""

    atv: Id
    reason: Text = "the way is blocked"
    problem: Problem = NOTHING_KNOWN
    """Details that its body knows."""


class Thing(StrEnum):
    """Obstacles on a lane."""

    PALLET = "pallet"
    PERSON = "person"
    DOOR = "door"


class LaneBlocked(FaultKind, frozen=True):
    """An obstacle is in the middle of a lane, and blocks it.

    A pallet and a door that is stuck stay until the fault is ended; a person goes on after a while (`dray_sim.faults.active`).
    """

    start: Id
    end: Id
    thing: Thing = Thing.PALLET


class DoorFailed(FaultKind, frozen=True):
    """A door of the plant file does not open any more, once it is shut."""

    door: Id


class LoadDropped(FaultKind, frozen=True):
    """A vehicle on a lane has lost its load, which lies behind it as an obstacle.

    A person puts it on board or takes it away.

    The vehicle stands until then; needs a load.
    """

    atv: Id


class LoadShifted(FaultKind, frozen=True):
    """A vehicle's load has slipped (paper, case 5); needs a load."""

    atv: Id


Fault = (
    NetworkFault
    | PoweredOff
    | Crashed
    | JournalLost
    | ClockSet
    | SentAway
    | MachineBroken
    | VehicleBroken
    | LaneBlocked
    | DoorFailed
    | LoadDropped
    | LoadShifted
)

KINDS: tuple[type[Fault], ...] = get_args(Fault)
KIND_NAMES: tuple[str, ...] = tuple(snake(kind.__name__) for kind in KINDS)
"""Names in `kind` on the wire."""


def kind_of(fault: Fault) -> str:
    """Its name on the wire."""
    return snake(type(fault).__name__)


def describe(fault: Fault) -> str:
    """One line for a reader: the kind, and all fields that differ from their defaults."""
    defaults = type(fault).__struct_defaults__
    names = fault.__struct_fields__
    required = len(names) - len(defaults)
    said = [
        f"{name}={getattr(fault, name)!r}"
        for place, name in enumerate(names)
        if place < required or getattr(fault, name) != defaults[place - required]
    ]
    return f"{kind_of(fault).replace('_', ' ')} ({', '.join(said)})"
