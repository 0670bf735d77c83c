"""Who is on duty and who calls for help: codes and places, without history."""

from __future__ import annotations

from typing import Literal

import msgspec

from dray.body import CallPart
from dray.gateway.live.views.base import View
from dray.messages import CallPlace, CallState, DutyStatus, ProblemKind

DutyChoice = Literal["on", "break", "off"]


class ColleagueView(View, kw_only=True):
    """Another person on duty."""

    code: str
    """Code of the duty, not of the person."""
    label: str = ""
    """The person's name; empty where names are hidden (`DRAY_OPERATOR_NAMES`)."""
    areas: tuple[str, ...] = ()
    """Those areas that the reader sees."""
    station: str = ""
    status: DutyStatus
    busy_with: str = ""
    """The caller being helped; empty for none."""
    until_at_s: float | None = None
    helps_with: tuple[ProblemKind, ...] = ()
    """Kinds of problems; empty for all."""


class CallView(View, kw_only=True):
    """An open call for help."""

    id: str
    caller: str
    goods: str = ""
    """The caller's transport whose goods wait on a failed vehicle; empty where the caller itself needs
    help."""
    state: CallState
    part: CallPart | None = None
    """The reader's part in it; null for none."""
    problem: ProblemKind
    needs_person: bool | None = None
    reason: str = ""
    since_at_s: float
    until_at_s: float | None = None
    """Deadline for an answer or for the promised arrival; after it others are asked."""
    asked: tuple[str, ...] = ()
    taken_by: str = ""
    on_duty: int = 0
    """Number of people on duty for that place, as far as the caller has heard."""
    x_m: float = 0.0
    y_m: float = 0.0
    place: CallPlace = CallPlace.PRESENT
    """How well the caller knows that place: `last` is where it was when it last knew, `untold` is its start in
    the plant file, since it has never told a place."""
    area: str = ""
    """Name of the area of that place; empty outside of all."""
    elsewhere: bool = False
    """Whether the place is outside the reader's areas: commands to the caller there are refused."""


class DutyView(View, kw_only=True):
    """The reader's duty, and that of others in the reader's areas."""

    state: DutyChoice
    code: str = ""
    """The reader's own code; empty while off duty."""
    said_off: bool = False
    """Whether the reader has gone off duty here; false while on duty, and while unknown, as after a gateway
    start."""
    helps_with: tuple[ProblemKind, ...] = ()
    """Kinds of problems the reader helps with; empty for all."""
    busy_until_at_s: float | None = None
    """End of the time for which the reader has said to be busy."""
    colleagues: tuple[ColleagueView, ...] = ()
    areas_without: tuple[str, ...] = ()
    """Areas with nobody on duty."""
    comes_at_s: dict[str, float] = msgspec.field(default_factory=dict)
    """For such areas outside their working time: when somebody comes again. An area is missing here if that
    is never, or if somebody should be there now."""
    calls: tuple[CallView, ...] = ()
    """Oldest first."""
