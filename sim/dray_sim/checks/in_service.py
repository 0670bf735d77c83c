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
        self._newest: dict[str, tuple[int, int]] = {}
        """By vehicle, the life and number of its newest heartbeat: one that neighbours pass on may be heard after a later one."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is AtvHeartbeat:
            # Whoever passes it on for one without WLAN is not meant, and passes it on later.
            atv, order = message.atv, (message.incarnation, message.seq)
            if order <= self._newest.get(atv, (0, 0)):
                return
            self._newest[atv] = order
            if message.out_of_service is UNSET:
                self._out.pop(atv, None)
            else:
                self._out.setdefault(atv, at_s)
        elif type(message) is Event and type(message.fact) is ContractTaken and sender in self._out:
            task, since_s = message.fact.task, self._out[sender]
            raise InvariantBroken(16, at_s, f"{sender} took {task}, out of service since {since_s:.1f} s")
