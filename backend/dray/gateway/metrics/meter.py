"""The meter: counts messages on the bus.

Facts are numbered by their agents; duplicates and late ones are counted once or not at all. Facts fetched
again after a loss are for the history, not for present rates.
"""

from __future__ import annotations

from typing import TypeVar

from prometheus_client import CollectorRegistry, Counter

from dray.gateway.metrics.auctions import Auctions
from dray.messages import AtvHeartbeat, Event, Link, MachineHeartbeat, Message
from dray.messages.fact import (
    AnyFact,
    BidRefused,
    CarrierChanged,
    GoalLost,
    GoodsDelivered,
    MemoryLost,
    OrderAccepted,
    OrderFulfilled,
    PieceMade,
    PrimarySuspected,
    TookOver,
)
from dray.messages.overtaken import LatestNumbers

AGENTS = 10_000
"""Maximum agents remembered: ten times those of the largest plant. It bounds invented ids."""


ORDERS = 50_000
"""Maximum orders remembered as counted, some 10 MB: many times those that end while a strategist is away."""

GOALS = 50_000
"""Maximum goals whose count is remembered, likewise."""

K = TypeVar("K")
V = TypeVar("V")


def _keep(known: dict[K, V], key: K, value: V, most: int) -> None:
    """Note an entry as the newest, and drop the oldest beyond the maximum."""
    known.pop(key, None)
    known[key] = value
    if len(known) > most:
        del known[next(iter(known))]


class Meter:
    """Counts.

    Args:
        registry: registry of the metrics.
    """

    def __init__(self, registry: CollectorRegistry) -> None:
        self._newest: LatestNumbers[str] = LatestNumbers(AGENTS)
        """Per agent, its newest counted fact, by incarnation and number."""
        self._orders: dict[tuple[type[AnyFact], str], None] = {}
        """Order facts already counted, since several strategists may report them."""
        self._arrived: dict[str, int] = {}
        """Per goal, pieces already counted, since a new holder of an order reports all arrivals again."""
        self._auctions = Auctions(registry)

        def counter(name: str, what: str, *labels: str) -> Counter:
            return Counter(f"dray_{name}", what, labels, registry=registry)

        self._messages = counter("bus_messages_heard", "Messages heard on the bus.", "kind")
        self._heartbeats = counter("heartbeats_heard", "Heartbeats heard.", "agent_kind", "link")
        self._facts = counter("facts_heard", "Facts heard for the first time.", "kind")
        self._refused = counter("bids_refused", "Tasks for which somebody did not bid, by reason.", "reason")
        self._changed = counter("carriers_changed", "Tasks that got another carrier.", "to")
        self._goods = counter("pieces_delivered", "Pieces that reached a delivery warehouse.")
        self._plain = {
            TookOver: counter("takeovers", "Secondaries that have taken a task over."),
            PrimarySuspected: counter("primaries_suspected", "Carriers that were silent for too long."),
            GoalLost: counter("goals_lost", "Goals with which a machine has failed."),
            MemoryLost: counter("memories_lost", "Agents that began without what bound them."),
            PieceMade: counter("pieces_made", "Pieces that machines have made."),
            OrderAccepted: counter("orders_accepted", "Orders that the strategist has taken."),
            OrderFulfilled: counter("orders_fulfilled", "Orders of which everything is delivered."),
        }

    def count(self, message: Message, now_s: float) -> None:
        """Count a message that came at this time of the plant's clock."""
        self._messages.labels(type(message).__name__).inc()
        match message:
            case AtvHeartbeat(link=link):
                self._heartbeats.labels("atv", link.value).inc()
            case MachineHeartbeat():
                self._heartbeats.labels("machine", Link.WLAN.value).inc()
            case Event(agent=agent) if self._newest.takes(
                agent, (message.incarnation, message.number), now_s
            ):
                self._facts.labels(type(message.fact).__name__).inc()
                self._count(message.fact)
                self._auctions.count(message)
            case _:
                pass

    def _count(self, fact: AnyFact) -> None:
        match fact:
            case BidRefused(reason=reason):
                self._refused.labels(reason.value).inc()
            case CarrierChanged(carrier=carrier):
                self._changed.labels("secondary" if carrier else "auction").inc()
            case GoodsDelivered(goal=goal, delivered=delivered):
                self._goods.inc(max(0, delivered - self._arrived.get(goal, 0)))
                _keep(self._arrived, goal, max(delivered, self._arrived.get(goal, 0)), GOALS)
            case OrderFulfilled(order=order) | OrderAccepted(order=order):
                if (type(fact), order) not in self._orders:
                    _keep(self._orders, (type(fact), order), None, ORDERS)
                    self._plain[type(fact)].inc()
            case _ if (plain := self._plain.get(type(fact))) is not None:
                plain.inc()
            case _:
                pass
