"""One plain transport that somebody has asked a place for, as long as it has not ended."""

from __future__ import annotations

from dray.memory import TransportMemory
from dray.messages import TransportOrdered, TransportState
from dray.messages.fact import TransportProgressed


class CalledTransport:
    """One that somebody has asked for."""

    __slots__ = (
        "ability",
        "attempt",
        "done",
        "due_s",
        "id",
        "item",
        "quantity",
        "source",
        "state",
        "task",
        "told",
        "vehicle",
        "vehicle_until_s",
    )

    def __init__(self, order: TransportOrdered) -> None:
        self.id, self.source, self.item = order.transport, order.source, order.item
        self.quantity, self.due_s = order.quantity, order.due_s
        self.vehicle, self.vehicle_until_s = order.vehicle, order.vehicle_until_s
        self.ability = order.ability
        self.state = TransportState.WAITING
        self.done = 0
        """Pieces that were counted."""
        self.attempt = 0
        self.task = ""
        """The name under which it is given out; empty while it waits for room."""
        self.told: TransportProgressed | None = None

    def memory(self) -> TransportMemory:
        """For the next life."""
        return TransportMemory(
            transport=self.id,
            source=self.source,
            item=self.item,
            quantity=self.quantity,
            due_s=self.due_s,
            vehicle=self.vehicle,
            state=self.state,
            done=self.done,
            attempt=self.attempt,
            vehicle_until_s=self.vehicle_until_s,
            ability=self.ability,
        )
