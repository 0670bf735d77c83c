"""What keeps a vehicle from going on: the kind of its problem, and what its body knows of it (paper, case 4)."""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Id, Message, Part, Seconds


class ProblemKind(StrEnum):
    """What is wrong. Whoever does not know says `UNKNOWN`, and words."""

    LOAD = "load"
    """The load has shifted, or its sensors contradict one another."""
    DRIVE = "drive"
    """A motor, a brake, a wheel: it cannot move by itself."""
    SENSOR = "sensor"
    """A laser scanner that is dirty, a camera that is blind."""
    BATTERY = "battery"
    WAY_BLOCKED = "way_blocked"
    """Something stands in its way that it cannot drive round."""
    LOST_POSITION = "lost_position"
    LINK = "link"
    """Between an agent and its vehicle: the agent lives, and cannot tell its vehicle what to do."""
    EMERGENCY_STOP = "emergency_stop"
    """Somebody has pressed the button, or a bumper was touched."""
    DOCK = "dock"
    """Whatever it docks at is not ready: a conveyor that stands, a door that is shut."""
    UNKNOWN = "unknown"


class Problem(Part, frozen=True):
    """What a vehicle's body knows of its problem beside the words; None for what it does not know."""

    kind: ProblemKind = ProblemKind.UNKNOWN
    passes: bool | None = None
    """It goes away by itself."""
    needs_person: bool | None = None
    """Somebody has to come. Neither this nor `passes` means that nothing helps."""
    load_movable: bool | None = None
    """What is on board can be taken off, by hand or by another vehicle."""


NOTHING_KNOWN = Problem()
"""A problem of which there are only words."""


class ProblemEnded(Message, frozen=True):
    """A problem is over: said once to all vehicles, so that they know how long such problems last."""

    atv: Id
    problem: Problem
    lasted_s: Seconds
