"""The problems that block a vehicle, in words for people.

Problems are FATAL errors, CRITICAL ones for a while (`criticals.py`), and an emergency stop. A manual mode, a lost position,
silence and a lost broker are problems, too. WARNING and URGENT are none: the vehicle goes on. Nor are errors about orders: they end
the order.
"""

from __future__ import annotations

from dray.adapters.vda5050.control.refusals import FATAL, is_about_order, is_critical
from dray.adapters.vda5050.control.view import NEVER_S, VehicleView
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import State, VehicleError
from dray.body import ProblemRaised
from dray.messages.base import METRES_MAX
from dray.messages.problem import Problem, ProblemKind

AWAY_S = 5.0
"""Seconds in which an absent vehicle or broker may return without a problem."""

SILENT_PERIODS = 2.2
"""Silence as a multiple of the longest gap between states: two were lost."""

REMARKS_MAX, REMARK_MAX = 3, 120
"""Remarks that are told with a problem, and the characters of each."""

OBEYS = frozenset({"AUTOMATIC", "SEMIAUTOMATIC"})
"""Modes in which its master decides where it drives."""

MODES = frozenset(
    {"AUTOMATIC", "SEMIAUTOMATIC", "STARTUP", "INTERVENED", "MANUAL", "SERVICE", "TEACHIN", "TEACH_IN"}
)


KINDS = (
    (ProblemKind.LOST_POSITION, ("locali", "position", "unknown_map")),
    (ProblemKind.BATTERY, ("battery", "charg", "power")),
    (ProblemKind.SENSOR, ("sensor", "scanner", "laser", "lidar", "camera")),
    (ProblemKind.LOAD, ("load", "fork", "lift", "gripper")),
    (ProblemKind.DRIVE, ("motor", "drive", "brake", "wheel", "steer")),
    (ProblemKind.WAY_BLOCKED, ("obstacle", "block", "unreachable", "no_route", "noroute", "path")),
    (ProblemKind.DOCK, ("dock", "conveyor", "station", "door")),
)
"""Parts of an error's type, and the likely kind; the first match counts. A profile is more exact."""


def absence(
    view: VehicleView, profile: Profile, unlinked: tuple[str, float] | None, now_s: float
) -> ProblemRaised | None:
    """Why the vehicle's state is unknown now; None when it is known.

    Args:
        view: the vehicle's messages.
        profile: its message periods.
        unlinked: the reason and time of the loss of the broker.
        now_s: the present time.
    """
    if unlinked is not None and now_s - unlinked[1] >= AWAY_S:
        return problem(f"the broker is away: {unlinked[0]}", ProblemKind.LINK)
    if view.heard_s == NEVER_S:
        return None
    if view.has_two_senders(now_s):
        return problem(
            "its states come from two senders: another vehicle or program uses its name",
            ProblemKind.LINK,
            needs_person=True,
        )
    silent_s = now_s - view.heard_s
    if view.away and now_s - view.away_s >= AWAY_S and silent_s >= AWAY_S:
        return problem(f"the vehicle is not there: {view.away}", ProblemKind.LINK)
    if unlinked is None and silent_s >= SILENT_PERIODS * profile.state_every_s:
        bound_s = SILENT_PERIODS * profile.state_every_s
        return problem(f"the vehicle says nothing, for {bound_s:.0f} s and more", ProblemKind.LINK)
    return None


def complaint(state: State, profile: Profile, *, critical: bool) -> ProblemRaised | None:
    """The problem that the vehicle itself reports; None for none.

    Args:
        state: the newest state.
        profile: its type's profile.
        critical: whether CRITICAL errors count as problems now (`Criticals`).
    """
    safety = state.safety_state
    if safety is not None and (stop := safety.emergency_stop):
        # The vehicle itself resets AUTOACK.
        person = stop != "AUTOACK"
        return problem(f"emergency stop ({stop})", ProblemKind.EMERGENCY_STOP, needs_person=person)
    mode = state.operating_mode or ""
    if mode in MODES and mode not in OBEYS:
        return problem(f"its mode is {mode}", needs_person=mode != "STARTUP")
    for error in state.errors or ():
        is_fatal = error.error_level == FATAL and not is_about_order(error)
        if critical if is_critical(error, profile) else is_fatal:
            return problem(
                error.text, kind_of(error, profile), needs_person=True if error.error_level == FATAL else None
            )
    position = state.position
    if position is not None and not position.is_localised:
        return problem("it does not know where it is: not localised", ProblemKind.LOST_POSITION)
    if position is not None and max(abs(position.x or 0.0), abs(position.y or 0.0)) > METRES_MAX:
        where = f"x {position.x or 0.0:g} m, y {position.y or 0.0:g} m"
        return problem(f"its position cannot be: {where}", ProblemKind.LOST_POSITION)
    return None


def remarks(state: State) -> str:
    """What a vehicle reports that is no problem by itself, and may be why it does not go on; empty for nothing."""
    mode = state.operating_mode or ""
    said = [f"operatingMode {mode}"] if mode and mode not in MODES else []
    said += [error.text for error in state.errors or ()]
    return "; ".join(text[:REMARK_MAX] for text in said[:REMARKS_MAX])


def problem(
    reason: str, kind: ProblemKind = ProblemKind.UNKNOWN, *, needs_person: bool | None = None
) -> ProblemRaised:
    """A problem in the form of a report."""
    return ProblemRaised(reason=reason, problem=Problem(kind=kind, needs_person=needs_person))


def kind_of(error: VehicleError, profile: Profile) -> ProblemKind:
    """The kind of an error: by the profile, else by its type."""
    if (kind := profile.problems.get(error.error_type or "")) is not None:
        return kind
    words = (error.error_type or "").lower()
    return next((kind for kind, parts in KINDS if any(part in words for part in parts)), ProblemKind.UNKNOWN)


def is_attended(state: State) -> bool:
    """Whether people operate it."""
    mode = state.operating_mode or ""
    return mode in MODES and mode not in OBEYS and mode != "STARTUP"
