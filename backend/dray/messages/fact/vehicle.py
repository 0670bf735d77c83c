"""Facts of a vehicle: its transport, its link, its problems, and people's commands."""

from __future__ import annotations

from dray.messages.base import Count, Id, IdOrNone, Seconds, Text
from dray.messages.fact.base import Fact
from dray.messages.heartbeat import AtvStatus, Phase
from dray.messages.kinds import BIDDERS, GATES, STATIONS, VEHICLES
from dray.messages.link import Link
from dray.messages.problem import NOTHING_KNOWN, Problem, ProblemKind
from dray.messages.reason import CommandRefusal


class LinkChanged(Fact, told_by=VEHICLES, frozen=True):
    """The vehicle is on the WLAN again, or has only its radio (paper, case 3)."""

    link: Link


class HelpAsked(Fact, told_by=BIDDERS, frozen=True):
    """The vehicle has a problem that a person can solve (paper, case 4)."""

    task: IdOrNone
    reason: Text
    until_s: Seconds
    problem: Problem = NOTHING_KNOWN


class HelpPromised(Fact, told_by=BIDDERS, frozen=True):
    """A person is on the way, and the takeover is held back until then."""

    until_s: Seconds
    promised_by: Text


class HelpCallEnded(Fact, told_by=BIDDERS | STATIONS, frozen=True):
    """A call for help is over, with its counts and its duration, and without names."""

    call: Id
    problem: ProblemKind
    asked: Count
    rounds: Count
    taken: Count
    """How often it was taken; above 1, an operator gave it back or did not come."""
    helped: bool
    """Whether an operator had taken it when it ended."""
    lasted_s: Seconds
    waited_s: Seconds | None = None
    """Time until it was first taken; None when it never was."""


class PhaseEntered(Fact, told_by=VEHICLES, frozen=True):
    """A transport went one step further."""

    task: Id
    epoch: Count
    phase: Phase
    station: IdOrNone = ""


class AtvStatusChanged(Fact, told_by=VEHICLES, frozen=True):
    """The vehicle's state machine took a step."""

    status: AtvStatus
    reason: Text = ""


class CommandObeyed(Fact, told_by=BIDDERS | STATIONS | GATES, frozen=True):
    """A person's command was carried out, or refused with a reason."""

    command: Id
    what: Text
    done: bool
    reason: CommandRefusal | None = None
    detail: Text = ""
    """What its sensors still report, if that is the reason."""
    issued_by: Text = ""


class ClosuresKnown(Fact, told_by=VEHICLES, frozen=True):
    """The vehicle obeys another list of closures from now on (`dray.messages.floor.closure`)."""

    number: Count
