"""Checks whether a driving vehicle approaches its next node: whatever its flags say, a long stand becomes a problem.

Possible reasons are its pause button, an obstacle, or unknown. After an obstacle other vehicles are told to avoid the lane. Position
and speed prevail over `driving` and `paused`.
"""

from __future__ import annotations

from dray.adapters.vda5050.control.problems import remarks
from dray.adapters.vda5050.control.vehicle_order import Kind, VehicleOrder
from dray.adapters.vda5050.control.view import VehicleView
from dray.adapters.vda5050.control.way import length_m
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import State
from dray.body import ProblemRaised, WayBlocked, WayFree
from dray.messages.problem import Problem, ProblemKind
from dray.plant import Plant
from dray.plant.model import VehicleType

PAUSED_S = 5.0
"""Seconds of `paused` and standing, without our request, that mean a pause by hand."""

OBSTACLE_S = 5.0
"""Seconds of standing before an obstacle after which the vehicle is blocked."""

FREE_S = 3.0
"""Seconds without showing the obstacle after which it is gone."""

NEARER_M = 0.1
"""Minimum progress; less is none."""

GONE_M = 0.3
"""Approach since the stand that means that the vehicle drives on."""

PATIENCE_S, TIMES = 15.0, 3.0
"""The allowed time of a lane: this factor times the time for its length and speed limit, plus these seconds and the longest gap
between two states."""

OBSTACLE_WORDS = ("obstacle", "block", "fieldviolation", "protectivefield", "safetyfield")
"""Parts of the type of an error that means standing before an obstacle."""

FATAL = "FATAL"


class Watch:
    """The progress of one vehicle.

    Args:
        plant: roads.
        kind: the type of the vehicle.
        profile: its type's profile.
        view: the vehicle's messages.
    """

    def __init__(self, plant: Plant, kind: VehicleType, profile: Profile, view: VehicleView) -> None:
        self._plant, self._kind, self._profile, self._view = plant, kind, profile, view
        self._about: tuple[VehicleOrder, int] | None = None
        """The watched order, and the last passed node."""
        self._nearest_m = float("inf")
        self._since_s = 0.0
        """The time of its last progress."""
        self._paused_s: float | None = None
        self._blocked_s: float | None = None
        """Since when it stands and shows an obstacle."""
        self._unblocked_s: float | None = None
        self._told: WayBlocked | None = None
        self._told_m = 0.0
        self.problem: ProblemRaised | None = None
        """Why it does not progress; None while it does."""

    def look(
        self, order: VehicleOrder | None, number: int, gap_m: float | None, now_s: float, *, may_drive: bool
    ) -> WayBlocked | WayFree | None:
        """Check a driving vehicle.

        Args:
            order: the shown order; None for none.
            number: the number of the agent's way.
            gap_m: its distance to the next node; None for an unknown position.
            now_s: the present time.
            may_drive: whether it is not held, and has no other known problem.

        Returns:
            A new report about an obstacle for its agent; None for none.
        """
        self.problem = None
        if order is None or order.kind is not Kind.STEP or order.passed >= order.end or not may_drive:
            self._about = self._paused_s = self._blocked_s = None
            return self._free(now_s, has_moved=order is None or order.passed >= order.end)
        if self._about != (order, order.passed):
            has_passed, self._about = self._about is not None, (order, order.passed)
            self._nearest_m, self._since_s = float("inf"), now_s
            if has_passed and self._told is not None:
                return self._free(now_s, has_moved=True)
        self._measure(gap_m, now_s)
        said = self._look_ahead(order, number, now_s)
        if self._told is None and not shows_obstacle(self._view.state):
            self.problem = self._why_paused(now_s)
        if self.problem is not None:
            self._since_s = now_s
        elif self._told is None and now_s - self._since_s >= self._patience_s(order):
            self.problem = self._stuck(order, now_s)
        return said

    def _measure(self, gap_m: float | None, now_s: float) -> None:
        """Measure by its position, else by the distance driven since its last node."""
        if gap_m is None:
            driven_m = self._view.driven_m
            gap_m = None if driven_m is None else -driven_m
        if gap_m is not None and gap_m < self._nearest_m - NEARER_M:
            self._nearest_m, self._since_s = gap_m, now_s

    def _why_paused(self, now_s: float) -> ProblemRaised | None:
        if self._view.state.paused is not True or self._view.is_moving:
            self._paused_s = None
            return None
        self._paused_s = now_s if self._paused_s is None else self._paused_s
        if now_s - self._paused_s < PAUSED_S:
            return None
        words = "it is paused, and not by its agent: let it go on at the vehicle (its pause button)"
        return ProblemRaised(reason=words, problem=Problem(kind=ProblemKind.UNKNOWN, needs_person=True))

    # --- what is in its way ----------------------------------------------------------------------

    def _look_ahead(self, order: VehicleOrder, number: int, now_s: float) -> WayBlocked | WayFree | None:
        if not shows_obstacle(self._view.state):
            self._blocked_s = None
            return self._free(now_s, has_moved=False)
        self._unblocked_s = None
        if self._view.is_moving:
            self._blocked_s = None
            return self._free(now_s, has_moved=self._nearest_m < self._told_m - GONE_M)
        self._blocked_s = now_s if self._blocked_s is None else self._blocked_s
        if now_s - self._blocked_s < OBSTACLE_S:
            return None
        if self._told is not None and self._told.order == number:
            return None
        start, end = order.nodes[order.passed], order.nodes[order.passed + 1]
        # After resuming, an agent has forgotten the report, and gets it again.
        # Its order contains the lane, and a base cannot be withdrawn: it does not turn round there.
        self._told = WayBlocked(order=number, start=start, end=end, entered=True)
        self._told_m = self._nearest_m
        return self._told

    def _free(self, now_s: float, *, has_moved: bool) -> WayFree | None:
        told = self._told
        if told is None:
            return None
        if not shows_obstacle(self._view.state):
            self._unblocked_s = now_s if self._unblocked_s is None else self._unblocked_s
            has_moved = has_moved or now_s - self._unblocked_s >= FREE_S
        if not has_moved:
            return None
        self._told = self._unblocked_s = None
        self._since_s = now_s
        return WayFree(order=told.order, start=told.start, end=told.end)

    # --- nobody knows why ------------------------------------------------------------------------

    def _patience_s(self, order: VehicleOrder) -> float:
        """The maximum time without progress."""
        start, end = order.nodes[order.passed], order.nodes[order.passed + 1]
        limit_mps = order.speeds_mps[order.passed + 1] or self._kind.max_speed_mps
        return (
            PATIENCE_S + self._profile.state_every_s + TIMES * length_m(self._plant, start, end) / limit_mps
        )

    def _stuck(self, order: VehicleOrder, now_s: float) -> ProblemRaised:
        node, for_s = order.nodes[order.passed + 1], self._patience_s(order)
        said = remarks(self._view.state)
        if self._view.state.driving and self._view.is_moving:
            why = "it says that it drives, and its position does not change"
        elif self._view.state.driving:
            why = "it says that it drives, at speed 0"
        else:
            why = "it stands" if said else "it stands, and does not say why"
        if said:
            why = f"{why}; it reports: {said}"
        return ProblemRaised(reason=f"it has not come nearer to {node} for {for_s:.0f} s: {why}")


def shows_obstacle(state: State) -> bool:
    """Whether a vehicle reports an obstacle, without an error that is a problem by itself."""
    if state.safety_state is not None and state.safety_state.field_violation is True:
        return True
    words = (
        (error.error_type or "").replace("_", "").lower()
        for error in state.errors or ()
        if error.error_level != FATAL
    )
    return any(piece in word for word in words for piece in OBSTACLE_WORDS)
