"""Invariant 6, on the carrier's side: no contract is ended that its coordinator still counts on.

The attribution of faults asks why a coordinator replaces a carrier. This check asks why a carrier gives up. It was
released, or told that others carry, though its coordinator names it as the carrier in that very epoch. A restart that
was over soon is no reason, for any agents and in any order.
"""

from __future__ import annotations

from dray.messages import Event, MachineHeartbeat, Message, Reason, Role
from dray.messages.fact import CarrierChanged, ContractEnded, MemoryLost, TaskClosed
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution

LET_GO = (Reason.RELEASED, Reason.SUPERSEDED)
"""Reasons with which a carrier ends its contract at the request of others."""


class Standing:
    """Watches contracts that both sides have.

    Args:
        attribution: knows which agents were in trouble.
    """

    hears = (MachineHeartbeat, Event)

    def __init__(self, attribution: FaultAttribution) -> None:
        self._attribution = attribution
        self._carriers: dict[str, tuple[str, int, str]] = {}
        """Carrier, epoch and coordinator of each open task, by its coordinator's last word."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note the carriers of tasks.

        Raises:
            InvariantBroken: a standing contract was ended, and no agent had a fault.
        """
        if type(message) is MachineHeartbeat:
            for brief in message.tasks:
                if brief.primary:
                    self._carriers[brief.task] = (brief.primary, brief.epoch, sender)
                else:
                    self._carriers.pop(brief.task, None)
        elif type(message) is Event:
            self._note(message, sender, at_s)

    def _note(self, event: Event, agent: str, at_s: float) -> None:
        fact = event.fact
        if isinstance(fact, TaskClosed | CarrierChanged):
            self._carriers.pop(fact.task, None)
        elif type(fact) is MemoryLost:
            self._carriers = {
                task: carrier for task, carrier in self._carriers.items() if agent not in carrier
            }
        elif type(fact) is ContractEnded and fact.role is Role.PRIMARY and fact.reason in LET_GO:
            carrier, epoch, coordinator = self._carriers.get(fact.task, ("", 0, ""))
            if (carrier, epoch) == (agent, fact.epoch) and not self._attribution.in_trouble(
                at_s, agent, coordinator
            ):
                seen = f"{agent} was told that it does not carry {fact.task} ({fact.reason}), on which {coordinator} counts"
                raise InvariantBroken(6, at_s, seen)
