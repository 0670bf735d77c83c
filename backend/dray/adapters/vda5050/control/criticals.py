"""CRITICAL errors: the vehicle stands and cannot continue its order, but takes others (VDA 5050 3.0, 6.6.5.1).

Some last until the next order is accepted (NODE_UNREACHABLE), so a driver that waits for their end waits for ever. Such an error is
a problem for a while, so that people see it; then orders are sent again. If an order does not end the error, it becomes a problem for
twice as long, and so on.
"""

from __future__ import annotations

from dray.adapters.vda5050.control.refusals import critical
from dray.adapters.vda5050.control.vehicle_order import VehicleOrder
from dray.adapters.vda5050.control.view import VehicleView
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import VehicleError

TOLD_S, TOLD_MAX_S = 5.0, 300.0
"""Duration of the problem: at first, and at most."""


class Criticals:
    """The CRITICAL errors of one vehicle.

    Args:
        view: the vehicle's messages.
        profile: its type's profile.
    """

    def __init__(self, view: VehicleView, profile: Profile) -> None:
        self._view, self._profile = view, profile
        self._type = ""
        """The type of the present or last error."""
        self._told_s = TOLD_S
        self._until_s = 0.0
        """The end of the problem."""
        self._gone_s: float | None = None

    def look(self, order: VehicleOrder | None, now_s: float) -> VehicleError | None:
        """Find the present error.

        Args:
            order: the vehicle's order, if its state shows it; None for none.
            now_s: the present time.

        Returns:
            The error that ends this order; None for none.
        """
        error = critical(self._view.state, self._profile)
        if error is None:
            self._gone_s = now_s if self._gone_s is None else self._gone_s
            return None
        kind = error.error_type or ""
        if kind != self._type or (self._gone_s is not None and now_s - self._gone_s > TOLD_MAX_S):
            self._type, self._told_s, self._until_s = kind, TOLD_S, now_s + TOLD_S
        elif self._gone_s is not None and now_s >= self._until_s:
            self._tell_longer(now_s)  # The error has returned.
        self._gone_s = None
        if order is None or self._view.is_moving or now_s < self._until_s:
            return None
        if now_s - max(order.offered_s, self._view.stirred_s) < TOLD_S:
            return None
        self._tell_longer(now_s)
        return error

    def is_told(self, now_s: float) -> bool:
        """Whether it is a problem now; afterwards orders are sent again."""
        return now_s < self._until_s

    def _tell_longer(self, now_s: float) -> None:
        self._until_s = now_s + self._told_s
        self._told_s = min(2.0 * self._told_s, TOLD_MAX_S)
