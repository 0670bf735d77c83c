"""What keeps a vehicle from going on, as people should read it.

FATAL and CRITICAL errors, an emergency stop, a mode in which people drive it, a lost position, silence and a broker that is
away are problems. WARNING and URGENT are not: the vehicle goes on.
"""

from __future__ import annotations

from dray.adapters.vda5050.control.view import NEVER_S, VehicleView
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import State

AWAY_S = 5.0
"""A vehicle that says it is away, or a broker that is, may be back before that."""

SILENT_PERIODS = 2.2
"""So many times the longest gap between two states without one: two were lost."""

STOPPING = frozenset({"FATAL", "CRITICAL"})
OBEYS = frozenset({"AUTOMATIC", "SEMIAUTOMATIC"})
"""In which its master decides where it drives."""

MODES = frozenset(
    {"AUTOMATIC", "SEMIAUTOMATIC", "STARTUP", "INTERVENED", "MANUAL", "SERVICE", "TEACHIN", "TEACH_IN"}
)


def absence(view: VehicleView, profile: Profile, unlinked: tuple[str, float] | None, now_s: float) -> str:
    """Why nothing is known of the vehicle now; empty when it is there.

    Args:
        view: what it has said.
        profile: how often it speaks.
        unlinked: why the broker is away, and since when.
        now_s: the present time.
    """
    if unlinked is not None and now_s - unlinked[1] >= AWAY_S:
        return f"the broker is away: {unlinked[0]}"
    if view.heard_s == NEVER_S:
        return ""
    silent_s = now_s - view.heard_s
    if view.away and now_s - view.away_s >= AWAY_S and silent_s >= AWAY_S:
        return f"the vehicle is not there: {view.away}"
    if unlinked is None and silent_s >= SILENT_PERIODS * profile.state_every_s:
        return f"the vehicle says nothing, for {SILENT_PERIODS * profile.state_every_s:.0f} s and more"
    return ""


def complaint(state: State) -> str:
    """What the vehicle itself says keeps it from going on; empty for nothing."""
    safety = state.safety_state
    if safety is not None and safety.emergency_stop:
        return f"emergency stop ({safety.emergency_stop})"
    mode = state.operating_mode or ""
    if mode in MODES and mode not in OBEYS:
        return f"its mode is {mode}"
    for error in state.errors or ():
        if error.error_level in STOPPING:
            return error.text
    position = state.position
    if position is not None and not position.is_localised:
        return "it does not know where it is: not localised"
    return ""


def is_attended(state: State) -> bool:
    """Whether people have it in their hands."""
    mode = state.operating_mode or ""
    return mode in MODES and mode not in OBEYS and mode != "STARTUP"
