"""The inbox: dispatches messages from the bus to the gateway's parts and the projection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dray.gateway.factory.commands import Commands
from dray.gateway.live.projection import Projection
from dray.gateway.live.strategist_probe import StrategistProbe
from dray.gateway.metrics.meter import Meter
from dray.gateway.orders.completions import Completions
from dray.gateway.orders.outbox import Outbox
from dray.gateway.orders.reconciliation import Reconciliation
from dray.gateway.orders.transports import PlainTransports
from dray.messages import (
    CancellationTaken,
    CommandAnswered,
    Event,
    HelpCall,
    Message,
    OperatorHeartbeat,
    OrderTaken,
    RevocationTaken,
    TransportAnswered,
)
from dray.messages.fact import Fact, MemoryLost, OrderFulfilled
from dray.messages.keys import STRATEGISTS
from dray.store.orders.progress import OPEN


@dataclass(frozen=True, slots=True)
class Inbox:
    """The receivers of messages in the gateway.

    Attributes:
        meter: counts all messages.
        strategist_probe: hears strategists.
        completions: hears the ends of orders.
        outbox: hears the strategists' other answers about orders.
        reconciliation: hears of ended orders that look open, and of lost memory.
        transports: hears places' answers about plain transports.
        commands: hears vehicles' answers to people.
        projection: hears heartbeats, events, operators and calls.
        plant_s: the plant's clock.
    """

    meter: Meter
    strategist_probe: StrategistProbe
    completions: Completions
    outbox: Outbox
    reconciliation: Reconciliation
    transports: PlainTransports
    commands: Commands
    projection: Projection
    plant_s: Callable[[], float]

    def receive(self, sender: str, message: Message) -> bool:
        """Hand a message on; returns whether a part awaited it."""
        self.meter.count(message, self.plant_s())
        is_strategist = sender in STRATEGISTS
        if is_strategist:
            self.strategist_probe.heard(sender)
        match message:
            case OrderTaken(fulfilled=True) | RevocationTaken():
                return not is_strategist or self.completions.on_answer(message)
            case OrderTaken(change=change) if change:
                if is_strategist:
                    self.completions.on_answer(message)
            case OrderTaken() | CancellationTaken():
                if is_strategist:
                    self.outbox.answered(message)
            case TransportAnswered():
                return self.transports.on_answered(sender, message)
            case OperatorHeartbeat() | HelpCall():
                return self.projection.people.fold(message, self.plant_s())
            case CommandAnswered():
                return self.commands.answered(sender, message)
            case _:
                self.projection.fold(message)
                if is_strategist and isinstance(message, Event):
                    self._doubt(message.fact)
        return True

    def _doubt(self, fact: Fact) -> None:
        """Ask for orders whose end a strategist reports, or which it may have forgotten."""
        match fact:
            case OrderFulfilled(order=order):
                known = self.projection.orders.get(order)
                if known is not None and known.status in OPEN:
                    self.reconciliation.doubt(order)
            case MemoryLost():
                self.reconciliation.doubt_all()
