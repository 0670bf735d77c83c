"""Problems of vehicles and machines: their kind, and what the body knows of them (paper, case 4)."""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Id, IdOrNone, Message, Part, Seconds, Text
from dray.messages.kinds import BIDDERS


class ProblemKind(StrEnum):
    """The kind of a problem; `UNKNOWN` comes with words only."""

    LOAD = "load"
    """The load has shifted, or its sensors contradict one another."""
    DRIVE = "drive"
    """A fault of a motor, a brake or a wheel: it cannot move by itself."""
    SENSOR = "sensor"
    """A dirty laser scanner, or a blind camera."""
    BATTERY = "battery"
    WAY_BLOCKED = "way_blocked"
    """An obstacle is in its way that it cannot drive round."""
    LOST_POSITION = "lost_position"
    LINK = "link"
    """The link between agent and vehicle has failed: the agent lives, but cannot control its vehicle."""
    EMERGENCY_STOP = "emergency_stop"
    """The button was pressed, or a bumper was touched."""
    DOCK = "dock"
    """The dock is not ready, as with a stopped conveyor or a shut door."""
    TOOL = "tool"
    """A tool of a machine is broken or worn."""
    JAM = "jam"
    """Something is stuck in a machine."""
    SOFTWARE = "software"
    """Its control program has failed."""
    UNKNOWN = "unknown"


class Problem(Part, frozen=True):
    """What a body knows of its problem beside the words; None when unknown."""

    kind: ProblemKind = ProblemKind.UNKNOWN
    passes: bool | None = None
    """Whether it goes away by itself."""
    needs_person: bool | None = None
    """Whether a person has to come. If this and `passes` are both false, nothing helps."""
    load_movable: bool | None = None
    """Whether the load can be taken off, by hand or by another vehicle."""


NOTHING_KNOWN = Problem()
"""A problem with words only."""


class ProblemEnded(Message, said_by=BIDDERS, signed="agent", frozen=True):
    """A problem is over: sent once to all agents of this kind, which learn how long such problems last."""

    agent: Id
    problem: Problem
    lasted_s: Seconds


class HelpWanted(Part, frozen=True):
    """A problem that a person can solve, and how long the task or the goals can wait for that (paper, cases 1 and 4)."""

    until_s: Seconds
    """Until when help is awaited (plant clock); then other agents take its task, or its goals."""
    promised_by: Text = ""
    """The person who is on the way; empty while none is."""


class StrandedGoods(Part, frozen=True, omit_defaults=True):
    """Goods on board of a failed vehicle, which wait for a person's decision."""

    atv: Id
    """The vehicle that carries them, or did before they were to be handed over."""
    node: IdOrNone
    """That vehicle's last known node; empty when unknown."""
    until_s: Seconds
    """When they are given up and made again (plant clock)."""
    handed_at: IdOrNone = ""
    """The node where a person hands them over to another vehicle; empty while none is set."""
