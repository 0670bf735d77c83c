"""Who is on duty, as one agent has heard."""

from __future__ import annotations

from dray.messages import DutyStatus, OperatorHeartbeat
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, bound_s, gone_s
from dray.protocol.runtime.bounded_map import BoundedMap

KNOWN_MAX = 256
"""More people than one shift of the largest plant has."""

SILENT_S = bound_s(IDLE_INTERVAL_S)
"""Who was not heard for so long is not asked."""

GONE_S = gone_s(IDLE_INTERVAL_S)
"""Who was not heard for so long does not come, whatever was promised."""


class OnDuty:
    """The operators that one agent knows of. Times are its own, whatever their clocks say."""

    def __init__(self) -> None:
        self._heard: BoundedMap[str, tuple[OperatorHeartbeat, float]] = BoundedMap(KNOWN_MAX)

    def note(self, heartbeat: OperatorHeartbeat, now_s: float) -> bool:
        """Note a heartbeat; False for one that was overtaken by a newer one."""
        operator = heartbeat.operator
        before = self._heard.get(operator)
        if before is not None and (heartbeat.incarnation, heartbeat.seq) <= (
            before[0].incarnation,
            before[0].seq,
        ):
            return False
        # Who was heard last is forgotten last.
        self._heard.pop(operator, None)
        self._heard[operator] = heartbeat, now_s
        return True

    def there(self, now_s: float) -> list[OperatorHeartbeat]:
        """Who is on duty: heard lately, and has not said to go."""
        return [
            heartbeat
            for heartbeat, heard_s in self._heard.values()
            if now_s - heard_s <= SILENT_S and not heartbeat.draining
        ]

    def can_be_asked(self, operator: str, now_s: float) -> bool:
        """Whether this one is there, and has no break."""
        known = self._heard.get(operator)
        if known is None or now_s - known[1] > SILENT_S or known[0].draining:
            return False
        return known[0].status is not DutyStatus.BREAK

    def has_gone(self, operator: str, now_s: float) -> bool:
        """Whether this one has said to go, or was not heard for longer than any link explains."""
        known = self._heard.get(operator)
        return known is None or known[0].draining or now_s - known[1] > GONE_S
