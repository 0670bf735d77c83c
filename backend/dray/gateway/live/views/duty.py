"""Who is on duty, and who calls for help: codes and places, and no history."""

from __future__ import annotations

from typing import Literal

import msgspec

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
    helps_with: tuple[ProblemKind, ...] = ()
    """What for; empty for everything."""


class CallView(View, kw_only=True):
    """A call for help that has not ended."""

    id: str
    caller: str
    goods: str = ""
    """The caller's transport whose goods wait on board of a failed vehicle; empty where the caller itself needs somebody."""
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
    area: str = ""
    """The name of the area in which that is; empty outside of all."""
    elsewhere: bool = False
    """It is in none of the reader's areas: what is asked of the caller there is refused."""


class DutyView(View, kw_only=True):
    """The reader's duty, and that of others in the reader's areas."""

    state: DutyChoice
    code: str = ""
    """The reader's own; empty while off duty."""
    said_off: bool = False
    """The reader has gone off duty here; false while on duty, and where that is not known, as after a start of the gateway."""
    helps_with: tuple[ProblemKind, ...] = ()
    """What the reader is there for; empty for everything."""
    busy_until_at_s: float | None = None
    """Until when the reader is busy by the own word."""
    colleagues: tuple[ColleagueView, ...] = ()
    areas_without: tuple[str, ...] = ()
    """Areas in which nobody is on duty."""
    comes_at_s: dict[str, float] = msgspec.field(default_factory=dict)
    """Of these, where nobody is there by the working time of the area: when somebody comes again. Where that is never, or somebody should be
    there now, it is not named."""
    calls: tuple[CallView, ...] = ()
    """The oldest first."""
