"""Operators on duty and calls for help, by their last messages. Nothing is stored: silent ones disappear."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from dray.messages import CallState, HelpCall, OperatorHeartbeat
from dray.messages.overtaken import LatestNumbers
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, bound_s

PEOPLE_MAX, CALLS_MAX = 256, 2_000
"""Maximum people and calls: more people than a shift has, and a call per vehicle and machine of the largest
plant."""

SILENT_S = bound_s(IDLE_INTERVAL_S)
"""Plant seconds of silence after which they are dropped: operators and callers speak every 5 s."""

_Key = TypeVar("_Key")
_Heard = TypeVar("_Heard")


class People:
    """The people of one plant. Times are the gateway's own, on the plant's clock."""

    def __init__(self) -> None:
        self._operators: dict[str, tuple[OperatorHeartbeat, float]] = {}
        self._calls: dict[tuple[str, str], tuple[HelpCall, float]] = {}
        """Calls by their subject."""
        self._newest: LatestNumbers[str] = LatestNumbers(PEOPLE_MAX)
        self._newest_calls: LatestNumbers[tuple[str, str]] = LatestNumbers(CALLS_MAX)

    def fold(self, message: OperatorHeartbeat | HelpCall, now_s: float) -> bool:
        """Note a message; False when a newer one came before."""
        if isinstance(message, HelpCall):
            return self._on_call(message, now_s)
        if not self._newest.takes(message.operator, (message.incarnation, message.seq), now_s):
            return False
        self._operators.pop(message.operator, None)
        self._operators[message.operator] = message, now_s
        _forget_oldest(self._operators, PEOPLE_MAX)
        return True

    def _on_call(self, call: HelpCall, now_s: float) -> bool:
        if not self._newest_calls.takes(call.subject, (call.incarnation, call.number), now_s):
            return False
        self._calls.pop(call.subject, None)
        self._calls[call.subject] = call, now_s
        _forget_oldest(self._calls, CALLS_MAX)
        return True

    def on_duty(self, now_s: float) -> Iterator[OperatorHeartbeat]:
        """The operators on duty now."""
        for heartbeat, heard_s in self._operators.values():
            if now_s - heard_s <= SILENT_S and not heartbeat.draining:
                yield heartbeat

    def calls(self, now_s: float) -> Iterator[HelpCall]:
        """The calls that are open now."""
        for call, heard_s in self._calls.values():
            if call.state is not CallState.ENDED and now_s - heard_s <= SILENT_S:
                yield call

    def call(self, name: str) -> HelpCall | None:
        """A call by its id, open or just ended; None for one that was never heard."""
        return next((call for call, _ in self._calls.values() if call.call == name), None)


def _forget_oldest(heard: dict[_Key, _Heard], most: int) -> None:
    if len(heard) > most:
        del heard[next(iter(heard))]
