"""Who is on duty, and who calls for help: codes and places, and no history."""

from __future__ import annotations

from typing import Literal

from dray.body import CallPart
from dray.gateway.live.views.base import View
from dray.messages import CallState, DutyStatus, ProblemKind

DutyChoice = Literal["on", "break", "off"]


class ColleagueView(View, kw_only=True):
    """Somebody else on duty."""

    code: str
    """Of the duty, not of the person."""
    label: str = ""
    """The person's name; empty where names are not told (`DRAY_OPERATOR_NAMES`)."""
    areas: tuple[str, ...] = ()
    """Of those that the reader sees."""
    station: str = ""
    status: DutyStatus
    busy_with: str = ""
    """Who has called; empty for nobody."""
    until_at_s: float | None = None


class CallView(View, kw_only=True):
    """A call for help that has not ended."""

    id: str
    caller: str
    state: CallState
    part: CallPart | None = None
    """What the reader has to do with it; null for nothing."""
    problem: ProblemKind
    needs_person: bool | None = None
    reason: str = ""
    since_at_s: float
    until_at_s: float | None = None
    """By when those who are asked answer, who has taken it is promised to be there, or others are asked."""
    asked: tuple[str, ...] = ()
    taken_by: str = ""
    on_duty: int = 0
    """How many are on duty for that place, as the caller has heard."""
    x_m: float = 0.0
    y_m: float = 0.0


class DutyView(View, kw_only=True):
    """The reader's duty, and that of others in the reader's areas."""

    state: DutyChoice
    code: str = ""
    """The reader's own; empty while off duty."""
    colleagues: tuple[ColleagueView, ...] = ()
    areas_without: tuple[str, ...] = ()
    """Areas in which nobody is on duty."""
    calls: tuple[CallView, ...] = ()
    """The oldest first."""
