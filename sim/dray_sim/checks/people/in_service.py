"""Invariant 16: a vehicle or a machine that is out of service takes no contract, and a machine makes nothing.

Like those of `dray_sim.checks.invariants`, this check hears the agents' own messages, and takes no part.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages import AtvHeartbeat, Event, MachineHeartbeat, Message, OutOfService
from dray.messages.fact import CommandObeyed, ContractTaken, PieceMade
from dray_sim.checks.broken import InvariantBroken

ONE_IN_WORK = 1
"""The piece that a machine was making comes out."""


class InServiceOnly:
    """No agent that says it is out of service takes a contract, as primary, as secondary or for a goal."""

    hears = (AtvHeartbeat, MachineHeartbeat, Event)

    def __init__(self) -> None:
        self._out: dict[str, tuple[OutOfService, float]] = {}
        """Agents that are out of service, with the kind and the beginning."""
        self._made: dict[str, int] = {}
        """Pieces of machines since then, or since they no longer finish their work."""
        self._newest: dict[str, tuple[int, int]] = {}
        """Life and number of an agent's newest heartbeat: one that neighbours pass on may be heard after a later one."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is AtvHeartbeat:
            # The sender may pass it on for a vehicle without WLAN, and later than the vehicle sent it.
            self._note(message.atv, message, at_s)
        elif type(message) is MachineHeartbeat:
            self._note(message.machine, message, at_s)
        elif type(message) is Event and sender in self._out:
            out, since_s = self._out[sender]
            if type(message.fact) is ContractTaken:
                task = message.fact.task
                raise InvariantBroken(16, at_s, f"{sender} took {task}, out of service since {since_s:.1f} s")
            if type(message.fact) is CommandObeyed and message.fact.what == "put_in" and message.fact.done:
                # This fact comes before its next heartbeat, and it works at once.
                self._back(sender)
            elif type(message.fact) is PieceMade and not out.after_work:
                made = self._made[sender] = self._made.get(sender, 0) + 1
                if made > ONE_IN_WORK:
                    goal = message.fact.goal
                    seen = f"{sender} works at {goal}, out of service since {since_s:.1f} s"
                    raise InvariantBroken(16, at_s, seen)

    def _note(self, agent: str, heartbeat: AtvHeartbeat | MachineHeartbeat, at_s: float) -> None:
        order = (heartbeat.incarnation, heartbeat.seq)
        if order <= self._newest.get(agent, (0, 0)):
            return
        self._newest[agent] = order
        if heartbeat.out_of_service is UNSET:
            self._back(agent)
        else:
            _, since_s = self._out.get(agent, (None, at_s))
            self._out[agent] = heartbeat.out_of_service, since_s
            if heartbeat.out_of_service.after_work:
                # It begins further pieces: once it no longer may, one of them is in work again.
                self._made.pop(agent, None)

    def _back(self, agent: str) -> None:
        self._out.pop(agent, None)
        self._made.pop(agent, None)
