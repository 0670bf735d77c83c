"""Invariant 11: no vehicle stands at a dock for its contract longer than its promised time plus two minutes.

A vehicle that waits longer is held by a shortage, and blocks others. A late vehicle's wait counts from its arrival
only. A speed limit or a restart on the way makes it late, and holds it up nowhere. A fault of an agent concerned
explains a wait, and so does a person who has stopped the vehicle (`fault_attribution`).
"""

from __future__ import annotations

from dray.messages import Accepted, AtvHeartbeat, Message, Phase, Role, TakenOver
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution

BEYOND_S = 120.0

AT_A_DOCK = frozenset({Phase.LOADING, Phase.UNLOADING})


class NobodyWaitsInVain:
    """Watches vehicles at docks.

    Args:
        attribution: knows which agents were in trouble.
        stations: whose trouble keeps vehicles waiting, too.
    """

    hears = (TakenOver, Accepted, AtvHeartbeat)

    def __init__(self, attribution: FaultAttribution, stations: tuple[str, ...]) -> None:
        self._attribution = attribution
        self._stations = stations
        self._promised_s: dict[str, tuple[str, float]] = {}
        """Last task and promised finish, by vehicle."""
        self._docked_s: dict[str, float] = {}
        """Arrival at a dock, by vehicle."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note promises, and look at standing vehicles.

        Raises:
            InvariantBroken: a vehicle waits without a fault.
        """
        if isinstance(message, TakenOver) or (isinstance(message, Accepted) and message.role is Role.PRIMARY):
            task, _ = self._promised_s.get(sender, ("", 0.0))
            if task != message.task:
                self._promised_s[sender] = (message.task, message.finish_s)
        elif type(message) is AtvHeartbeat:
            self._look(message, at_s)

    def _look(self, heartbeat: AtvHeartbeat, at_s: float) -> None:
        brief = heartbeat.task
        task, promised_s = self._promised_s.get(heartbeat.atv, ("", 0.0))
        if brief is None or brief.phase not in AT_A_DOCK:
            self._docked_s.pop(heartbeat.atv, None)
        if brief is None or brief.task != task:
            self._promised_s.pop(heartbeat.atv, None)
            return
        if brief.phase not in AT_A_DOCK:
            return
        waits_s = at_s - max(promised_s, self._docked_s.setdefault(heartbeat.atv, at_s))
        if waits_s <= BEYOND_S:
            return
        if not self._attribution.in_trouble(at_s, heartbeat.atv, brief.coordinator, *self._stations):
            seen = f"{heartbeat.atv} is {brief.phase} for {task} {waits_s:.0f} s after its promise"
            raise InvariantBroken(11, at_s, seen)
