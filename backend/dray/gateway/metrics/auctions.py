"""Auctions and tasks: counts, durations, rounds and bids."""

from __future__ import annotations

from typing import TypeVar

from prometheus_client import CollectorRegistry, Counter, Histogram

from dray.messages import Event, Production, Role
from dray.messages.fact import AwardAnswered, BidReceived, RoundFailed, TaskClosed, TaskOpened
from dray.messages.keys import STRATEGISTS

K = TypeVar("K")
V = TypeVar("V")

OPEN = 10_000
"""Maximum tasks and auctions followed at once; beyond that the oldest are dropped unmeasured."""

AUCTION_BUCKETS_S = (1.0, 2.0, 3.0, 5.0, 8.0, 15.0, 30.0, 60.0, 120.0, 300.0)
"""One round takes some 3 s; a machine without bidders asks for minutes."""

TRANSPORT_BUCKETS_S = (30.0, 60.0, 90.0, 120.0, 180.0, 240.0, 360.0, 600.0, 1200.0, 3600.0)
"""The default plant takes two or three minutes; with a takeover, twice as long."""

COUNT_BUCKETS = (0.0, 1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 21.0, 50.0)

PRODUCTION, TRANSPORT = "production", "transport"
ACCEPTED = "accepted"
DELIVERED, WITHDRAWN, OTHER = "delivered", "withdrawn", "other"


class _Auction:
    """A search for a primary or a secondary."""

    __slots__ = ("bids", "opened_s", "rounds")

    def __init__(self, opened_s: float) -> None:
        self.opened_s = opened_s
        self.rounds = self.bids = 0


class Auctions:
    """Measures auctions and tasks whose begin was heard here.

    Args:
        registry: registry of the metrics.
    """

    def __init__(self, registry: CollectorRegistry) -> None:
        self._opened_s: dict[str, float] = {}
        """Open transports -> time of their announcement (plant clock)."""
        self._auctions: dict[tuple[str, Role], _Auction] = {}

        def counter(name: str, what: str, *labels: str) -> Counter:
            return Counter(f"dray_{name}", what, labels, registry=registry)

        def histogram(name: str, what: str, buckets: tuple[float, ...], *labels: str) -> Histogram:
            return Histogram(f"dray_{name}", what, labels, buckets=buckets, registry=registry)

        self._tasks_opened = counter("tasks_opened", "Tasks announced.", "work")
        self._tasks_closed = counter("tasks_closed", "Tasks that ended.", "work", "outcome")
        self._transport_s = histogram(
            "transport_duration_seconds", "Announcement to handover, plant clock.", TRANSPORT_BUCKETS_S
        )
        self._auction_s = histogram(
            "auction_duration_seconds", "First round to contract, plant clock.", AUCTION_BUCKETS_S, "role"
        )
        self._rounds = histogram("auction_rounds", "Rounds until a contract.", COUNT_BUCKETS, "role")
        self._bids = histogram("auction_bids", "Bids of one round.", COUNT_BUCKETS, "role")
        self._failed = counter("auction_rounds_failed", "Rounds in which nobody was contracted.", "role")

    def count(self, event: Event) -> None:
        """Take in a coordinator's event."""
        match event.fact:
            case TaskOpened() as fact:
                self._open(fact, event.at_s)
            case BidReceived(task=task, role=role):
                if (auction := self._auctions.get((task, role))) is not None:
                    auction.bids += 1
            case AwardAnswered(task=task, role=role, answer=answer):
                if answer == ACCEPTED:
                    self._contract(task, role, event.at_s)
            case RoundFailed(role=role, bids=bids):
                self._failed.labels(role.value).inc()
                self._bids.labels(role.value).observe(bids)
            case TaskClosed() as fact:
                self._close(event.agent, fact, event.at_s)
            case _:
                pass

    def _open(self, fact: TaskOpened, at_s: float) -> None:
        if fact.role is Role.PRIMARY and fact.epoch == fact.round == 1:
            produces = isinstance(fact.work, Production)
            self._tasks_opened.labels(PRODUCTION if produces else TRANSPORT).inc()
            if not produces:
                _put(self._opened_s, fact.task, at_s)
        key = (fact.task, fact.role)
        if fact.round == 1:
            _put(self._auctions, key, _Auction(at_s))
        if (auction := self._auctions.get(key)) is not None:
            auction.rounds, auction.bids = fact.round, 0

    def _contract(self, task: str, role: Role, at_s: float) -> None:
        auction = self._auctions.pop((task, role), None)
        if auction is not None:
            self._auction_s.labels(role.value).observe(at_s - auction.opened_s)
            self._rounds.labels(role.value).observe(auction.rounds)
            self._bids.labels(role.value).observe(auction.bids)

    def _close(self, coordinator: str, fact: TaskClosed, at_s: float) -> None:
        for role in Role:
            self._auctions.pop((fact.task, role), None)
        opened_s = self._opened_s.pop(fact.task, None)
        outcome = fact.outcome if fact.outcome in {DELIVERED, WITHDRAWN} else OTHER
        work = PRODUCTION if coordinator in STRATEGISTS else TRANSPORT
        self._tasks_closed.labels(work, outcome).inc()
        if opened_s is not None and outcome == DELIVERED:
            self._transport_s.observe(at_s - opened_s)


def _put(there: dict[K, V], key: K, value: V) -> None:
    """Store an entry, and drop the oldest if there are too many."""
    if len(there) >= OPEN:
        del there[next(iter(there))]
    there[key] = value
