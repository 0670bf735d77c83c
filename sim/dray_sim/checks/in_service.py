"""Invariant 16: a vehicle that is out of service takes no contract.

A check like those of `dray_sim.checks.invariants`: it hears what vehicles say of themselves, and takes no part.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages import AtvHeartbeat, Event, Message
from dray.messages.fact import ContractTaken
from dray_sim.checks.broken import InvariantBroken


class InServiceOnly:
    """No vehicle takes a contract, as primary or secondary, after it has said that it is out of service."""

    def __init__(self) -> None:
        self._out: dict[str, float] = {}
        """Vehicles that are out of service, and since when."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is AtvHeartbeat:
            if message.out_of_service is UNSET:
                self._out.pop(sender, None)
            else:
                self._out.setdefault(sender, at_s)
        elif type(message) is Event and type(message.fact) is ContractTaken and sender in self._out:
            task, since_s = message.fact.task, self._out[sender]
            raise InvariantBroken(16, at_s, f"{sender} took {task}, out of service since {since_s:.1f} s")
