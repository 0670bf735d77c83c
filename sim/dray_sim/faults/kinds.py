"""The kinds of faults: each is a value that says what is wrong, not when.

Those of the network are data of the network (`dray_sim.network.faults`); here are those of power, processes and bodies.
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
    """An agent's process has ended; its body goes on as bodies do. It is started again at the end."""

    agent: Id


class JournalLost(FaultKind, frozen=True):
    """An agent's process has ended, and what it had written down is lost or torn: it is started again without memory."""

    agent: Id


class ClockSet(FaultKind, frozen=True):
    """The clock of an agent's computer was set forward by so much, or back, and is set right at the end."""

    agent: Id
    by_s: Annotated[float, Meta(ge=-3600.0, le=3600.0)]


class SentAway(FaultKind, frozen=True):
    """An agent was asked to shut down gracefully, for other software say; it is started again at the end.

    Who has not left by then is ended.
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
    """What its body knows of it."""


class VehicleBroken(FaultKind, frozen=True):
    """A vehicle has a problem (paper, case 4)."""

    atv: Id
    reason: Text = "the way is blocked"
    problem: Problem = NOTHING_KNOWN
    """What its body knows of it."""


class Thing(StrEnum):
    """What can be in the way on a lane."""

    PALLET = "pallet"
    PERSON = "person"
    DOOR = "door"


class LaneBlocked(FaultKind, frozen=True):
    """Something is in the middle of a lane, and in the way of whoever would drive there.

    A pallet and a door that is stuck stay until the fault is ended; a person goes on after a while (`dray_sim.faults.active`).
    """

    start: Id
    end: Id
    thing: Thing = Thing.PALLET


class DoorFailed(FaultKind, frozen=True):
    """A door of the plant file does not open any more, once it is shut."""

    door: Id


class LoadDropped(FaultKind, frozen=True):
    """A vehicle on a lane has lost its load: it lies behind it, and is in the way, until a person has put it on board or taken it away.

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
"""As they stand in `kind` on the wire."""


def kind_of(fault: Fault) -> str:
    """Its name on the wire."""
    return snake(type(fault).__name__)


def describe(fault: Fault) -> str:
    """One line for a reader: the kind, and what is not left at its default."""
    defaults = type(fault).__struct_defaults__
    names = fault.__struct_fields__
    required = len(names) - len(defaults)
    said = [
        f"{name}={getattr(fault, name)!r}"
        for place, name in enumerate(names)
        if place < required or getattr(fault, name) != defaults[place - required]
    ]
    return f"{kind_of(fault).replace('_', ' ')} ({', '.join(said)})"
