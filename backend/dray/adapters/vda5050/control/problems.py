"""What keeps a vehicle from going on, as people should read it.

FATAL errors, CRITICAL ones for a while (`criticals.py`), an emergency stop, a mode in which people drive it, a lost position, silence and
a broker that is away are problems. WARNING and URGENT are not: the vehicle goes on. Nor are errors about orders: they end the order.
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
"""A vehicle that says it is away, or a broker that is, may be back before that."""

SILENT_PERIODS = 2.2
"""So many times the longest gap between two states without one: two were lost."""

OBEYS = frozenset({"AUTOMATIC", "SEMIAUTOMATIC"})
"""In which its master decides where it drives."""

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
"""Pieces of an error's type, and what is probably wrong; the first that fits. A profile says it better."""


def absence(
    view: VehicleView, profile: Profile, unlinked: tuple[str, float] | None, now_s: float
) -> ProblemRaised | None:
    """Why nothing is known of the vehicle now; None when it is there.

    Args:
        view: what it has said.
        profile: how often it speaks.
        unlinked: why the broker is away, and since when.
        now_s: the present time.
    """
    if unlinked is not None and now_s - unlinked[1] >= AWAY_S:
        return problem(f"the broker is away: {unlinked[0]}", ProblemKind.LINK)
    if view.heard_s == NEVER_S:
        return None
    silent_s = now_s - view.heard_s
    if view.away and now_s - view.away_s >= AWAY_S and silent_s >= AWAY_S:
        return problem(f"the vehicle is not there: {view.away}", ProblemKind.LINK)
    if unlinked is None and silent_s >= SILENT_PERIODS * profile.state_every_s:
        bound_s = SILENT_PERIODS * profile.state_every_s
        return problem(f"the vehicle says nothing, for {bound_s:.0f} s and more", ProblemKind.LINK)
    return None


def complaint(state: State, profile: Profile, *, critical: bool) -> ProblemRaised | None:
    """What the vehicle itself says keeps it from going on; None for nothing.

    Args:
        state: the newest one.
        profile: of its type.
        critical: CRITICAL errors are among that now (`Criticals`).
    """
    safety = state.safety_state
    if safety is not None and (stop := safety.emergency_stop):
        # AUTOACK is taken back by the vehicle itself.
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


def problem(
    reason: str, kind: ProblemKind = ProblemKind.UNKNOWN, *, needs_person: bool | None = None
) -> ProblemRaised:
    """As it is reported."""
    return ProblemRaised(reason=reason, problem=Problem(kind=kind, needs_person=needs_person))


def kind_of(error: VehicleError, profile: Profile) -> ProblemKind:
    """What an error is about: by the profile, else by its type."""
    if (kind := profile.problems.get(error.error_type or "")) is not None:
        return kind
    words = (error.error_type or "").lower()
    return next((kind for kind, parts in KINDS if any(part in words for part in parts)), ProblemKind.UNKNOWN)


def is_attended(state: State) -> bool:
    """Whether people have it in their hands."""
    mode = state.operating_mode or ""
    return mode in MODES and mode not in OBEYS and mode != "STARTUP"
