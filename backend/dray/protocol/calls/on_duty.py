"""The operators on duty, as one agent has heard them."""

from __future__ import annotations

from dray.messages import DutyStatus, OperatorHeartbeat
from dray.messages.overtaken import LatestNumbers
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, bound_s, gone_s
from dray.protocol.runtime.bounded_map import BoundedMap

KNOWN_MAX = 256
"""Maximum known operators: more than one shift of the largest plant has."""

SILENT_S = bound_s(IDLE_INTERVAL_S)
"""Silence after which an operator is not asked (s)."""

GONE_S = gone_s(IDLE_INTERVAL_S)
"""Silence after which an operator does not come, in spite of any promise (s)."""


class OnDuty:
    """The operators that one agent knows of. Times are the agent's own, because operators' clocks may differ."""

    def __init__(self) -> None:
        self._heard: BoundedMap[str, tuple[OperatorHeartbeat, float]] = BoundedMap(KNOWN_MAX)
        self._newest: LatestNumbers[str] = LatestNumbers(KNOWN_MAX)

    def note(self, heartbeat: OperatorHeartbeat, now_s: float) -> bool:
        """Note a heartbeat; False if a newer one has overtaken it."""
        operator = heartbeat.operator
        if not self._newest.takes(operator, (heartbeat.incarnation, heartbeat.seq), now_s):
            return False
        # The operator heard last is forgotten last.
        self._heard.pop(operator, None)
        self._heard[operator] = heartbeat, now_s
        return True

    def there(self, now_s: float) -> list[OperatorHeartbeat]:
        """Operators on duty: heard lately, and not leaving."""
        return [
            heartbeat
            for heartbeat, heard_s in self._heard.values()
            if now_s - heard_s <= SILENT_S and not heartbeat.draining
        ]

    def can_be_asked(self, operator: str, now_s: float) -> bool:
        """Whether an operator is there, and has no break."""
        known = self._heard.get(operator)
        if known is None or now_s - known[1] > SILENT_S or known[0].draining:
            return False
        return known[0].status is not DutyStatus.BREAK

    def has_gone(self, operator: str, now_s: float) -> bool:
        """Whether an operator has left, or was silent for longer than any link explains."""
        known = self._heard.get(operator)
        return known is None or known[0].draining or now_s - known[1] > GONE_S
