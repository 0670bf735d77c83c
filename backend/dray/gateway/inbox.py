"""The inbox: what the gateway hears on the bus goes to whoever waits for it; all that agents tell, to the projection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dray.gateway.factory.commands import Commands
from dray.gateway.live.projection import Projection
from dray.gateway.live.strategist_probe import StrategistProbe
from dray.gateway.metrics.meter import Meter
from dray.gateway.orders.completions import Completions
from dray.gateway.orders.outbox import Outbox
from dray.gateway.orders.transports import PlainTransports
from dray.messages import (
    CancellationTaken,
    CommandAnswered,
    HelpCall,
    Message,
    OperatorHeartbeat,
    OrderTaken,
    RevocationTaken,
    TransportAnswered,
)
from dray.messages.keys import STRATEGIST


@dataclass(frozen=True, slots=True)
class Inbox:
    """Who in the gateway hears what.

    Attributes:
        meter: counts everything.
        strategist_probe: learns that the strategist is there.
        completions: how orders have ended.
        outbox: the strategist's other answers about orders.
        transports: places' answers about plain transports.
        commands: vehicles' answers to people.
        projection: heartbeats and events; who is on duty, and who calls.
        plant_s: the plant's clock.
    """

    meter: Meter
    strategist_probe: StrategistProbe
    completions: Completions
    outbox: Outbox
    transports: PlainTransports
    commands: Commands
    projection: Projection
    plant_s: Callable[[], float]

    def receive(self, sender: str, message: Message) -> bool:
        """Hand a message on; returns whether anybody waited for it."""
        self.meter.count(message)
        if sender == STRATEGIST:
            self.strategist_probe.heard()
        match message:
            case OrderTaken(fulfilled=True) | RevocationTaken():
                return sender != STRATEGIST or self.completions.on_answer(message)
            case OrderTaken() | CancellationTaken():
                if sender == STRATEGIST:
                    self.outbox.answered(message)
            case TransportAnswered():
                return self.transports.on_answered(sender, message)
            case OperatorHeartbeat() | HelpCall():
                return self.projection.people.fold(message, self.plant_s())
            case CommandAnswered():
                return self.commands.answered(sender, message)
            case _:
                self.projection.fold(message)
        return True
