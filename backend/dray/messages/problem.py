"""What keeps a vehicle or a machine from going on: the kind of its problem, and what its body knows of it (paper, case 4)."""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Id, IdOrNone, Message, Part, Seconds, Text
from dray.messages.kinds import BIDDERS


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
    TOOL = "tool"
    """A tool of a machine is broken or worn."""
    JAM = "jam"
    """Something is stuck in a machine."""
    SOFTWARE = "software"
    """Its control program has failed."""
    UNKNOWN = "unknown"


class Problem(Part, frozen=True):
    """What the body of a vehicle or a machine knows of its problem beside the words; None for what it does not know."""

    kind: ProblemKind = ProblemKind.UNKNOWN
    passes: bool | None = None
    """It goes away by itself."""
    needs_person: bool | None = None
    """Somebody has to come. Neither this nor `passes` means that nothing helps."""
    load_movable: bool | None = None
    """What is on board can be taken off, by hand or by another vehicle."""


NOTHING_KNOWN = Problem()
"""A problem of which there are only words."""


class ProblemEnded(Message, said_by=BIDDERS, signed="agent", frozen=True):
    """A problem is over: said once to all of its kind, so that they know how long such problems last."""

    agent: Id
    problem: Problem
    lasted_s: Seconds


class HelpWanted(Part, frozen=True):
    """A problem that a person can solve, and how long the task, or a machine's goals, can wait for that (paper, cases 1 and 4)."""

    until_s: Seconds
    """Solved by then (plant clock), it goes on; else somebody else takes its task, or its goals."""
    promised_by: Text = ""
    """Who has said to be on the way; empty while nobody has."""


class StrandedGoods(Part, frozen=True, omit_defaults=True):
    """Goods that wait for a person's word, since the vehicle that has them on board has failed."""

    atv: Id
    """On board of which vehicle they are, or were before they could be handed over."""
    node: IdOrNone
    """Where that was heard last; empty where nobody knows."""
    until_s: Seconds
    """They are given up then, and made again (plant clock)."""
    handed_at: IdOrNone = ""
    """Where a person hands them over to another vehicle; empty while nobody has said so."""
