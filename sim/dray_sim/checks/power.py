"""Invariant 12: in a run without faults no vehicle runs flat. Chargers suffice there; see `run`."""

from __future__ import annotations

from dray.messages import AtvHeartbeat, Message
from dray_sim.bodies.condition import BATTERY_EMPTY
from dray_sim.checks.broken import InvariantBroken


class Powered:
    """Watches the batteries of a run in which nothing goes wrong."""

    def hear(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        """See `dray_sim.network.listeners.Listener`.

        Raises:
            InvariantBroken: a vehicle says that its battery is empty.
        """
        if type(message) is AtvHeartbeat and message.problem == BATTERY_EMPTY:
            seen = f"{message.atv} has run flat at {message.node} though nothing had gone wrong"
            raise InvariantBroken(12, at_s, seen)
