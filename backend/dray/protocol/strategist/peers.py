"""The other strategists of a plant: which of them live, and their numbers of orders in work."""

from __future__ import annotations

from dray.messages import StrategistHeartbeat
from dray.messages.keys import Keys
from dray.messages.overtaken import LatestNumbers
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S, WORKING_INTERVAL_S
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.timers import spread_frac
from dray.protocol.strategist.order_book import OrderBook

PEER_SILENCE_S = GOAL_SILENCE_S
"""Silence after which a strategist's orders are taken over (s): a restart takes less."""


class Peers:
    """The peers of one strategist.

    Args:
        others: all other strategists of the plant.
        keys: the plant's bus keys.
        life: the strategist's life; its alarm is named `BEAT`.
        book: the strategist's orders.
    """

    def __init__(
        self,
        others: tuple[str, ...],
        keys: Keys,
        life: Life,
        book: OrderBook,
    ) -> None:
        self._agent, self._keys, self._life = life.agent, keys, life
        self._book = book
        self._heard_s = dict.fromkeys(others, 0.0)
        self._newest: LatestNumbers[str] = LatestNumbers()
        """The newest heartbeats, by incarnation and number."""
        self._load = dict.fromkeys(others, 0)

    def start(self, now_s: float) -> None:
        """Start heartbeats and subscriptions; all peers are assumed to live until they have had time to speak."""
        self._heard_s = dict.fromkeys(self._heard_s, now_s)
        self._life.subscribe(self._keys.all_strategist_heartbeats)
        for other in self._heard_s:
            self._life.subscribe(self._keys.events(other))
        self._life.beat_soon(now_s)

    def beat(self, now_s: float) -> None:
        """Send a heartbeat."""
        said = StrategistHeartbeat(
            self._agent, self._life.incarnation, self._life.count_beat(), now_s, self._book.in_work
        )
        self._life.publish(self._keys.strategist_heartbeat(self._agent), said)
        self._life.beat_again(WORKING_INTERVAL_S, now_s)

    def on_heartbeat(self, sender: str, heartbeat: StrategistHeartbeat, now_s: float) -> None:
        """Note a peer's heartbeat."""
        number = (heartbeat.incarnation, heartbeat.seq)
        if sender in self._heard_s and self._newest.takes(sender, number, now_s):
            self._heard_s[sender], self._load[sender] = now_s, heartbeat.orders

    def excuse(self, span_s: float) -> None:
        """The strategist's own process was held up for this long: peers' silence in that time does not count."""
        for other in self._heard_s:
            self._heard_s[other] += span_s

    def is_silent(self, other: str, now_s: float) -> bool:
        """Whether a peer has failed; an agent that is no strategist of this plant counts as failed."""
        heard_s = self._heard_s.get(other)
        return heard_s is None or now_s >= heard_s + PEER_SILENCE_S

    def any_silent(self, now_s: float) -> bool:
        return any(self.is_silent(other, now_s) for other in self._heard_s)

    def before(self, order: str, now_s: float) -> int:
        """How many peers bid less for an order: fewer orders in work, or as many and an earlier rank by name."""
        own = (self._book.in_work, spread_frac(f"{order} {self._agent}"), self._agent)
        return sum(
            not self.is_silent(other, now_s) and (load, spread_frac(f"{order} {other}"), other) < own
            for other, load in self._load.items()
        )
