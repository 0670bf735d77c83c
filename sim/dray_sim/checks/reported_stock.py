"""Invariant 28: the stock that a station reports lies there, and orders find room, also after a storage has filled itself.

A report may be a moment old, or of a life that has not heard of a change yet. A report that stays wrong for `WRONG_S`
is an error, or for `WRONG_LEVEL_S` where a controller stands between station and storage. A returned load comes
without an order. A load that has just been put down is both on order and there until its carrier has said so. A
station that has lost its journal hears from a carrier of an order that an earlier life made while there was room; its
body may have filled that room since, and the load on board comes all the same. So only orders beyond these are judged.

What comes by itself is judged between two heartbeats of one life, by what was on order at both. While vehicles wait
for more than lies there, no room is kept for loads without a carrier. A controller with signals is told of no orders.
"""

from __future__ import annotations

from collections import Counter

from dray.messages import Message, StationHeartbeat, StockLevel
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

WRONG_S = 30.0
"""A station hears of a change at once, and tells it; one that has just been started counts first."""

WRONG_LEVEL_S = 300.0
"""A level counts once it has rested while no vehicle stood at the dock, and its controller may be away. So the time in
which one stands there does not count, nor the time in which the station itself was down."""


class ReportedStock:
    """Checks one factory."""

    hears = (StationHeartbeat,)

    def __init__(self, factory: SimFactory) -> None:
        self._factory, self._storages = factory, factory.floor.storages
        self._wrong_s = WRONG_LEVEL_S if factory.has_levels else WRONG_S
        self._right_s: dict[tuple[str, str], float] = {}
        """Last moment at which a report was right, by station and item."""
        self._last: dict[tuple[str, str], StockLevel] = {}
        self._unasked: Counter[tuple[str, str]] = Counter()
        """Pieces without an order of this life, as long as there are more than find room."""
        self._lives: dict[str, int] = {}
        """By station: the life of its last heartbeat."""
        self._told: dict[tuple[str, str], int] = {}
        """By station and task: the last life that told of it."""
        self._filled: dict[tuple[str, str], int] = {}
        """Refills that this check has seen, by station and item."""
        self._heard_of: Counter[tuple[str, str]] = Counter()
        """Pieces of orders that an earlier life made and this one has heard of, until they count as on order."""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance.

        Raises:
            InvariantBroken: something else lies there, more is ordered than finds room, or room for orders was filled up.
        """
        if type(message) is not StationHeartbeat or sender not in self._storages:
            return
        goes_on = self._lives.get(sender) == message.incarnation
        self._note_orders(message)
        stock = self._storages[sender].stock
        for told in message.stocks:
            key = sender, told.item
            if told.level == stock[told.item] or self._is_unread(sender) or not goes_on:
                self._right_s[key] = at_s
            elif at_s > self._right_s.setdefault(key, at_s) + self._wrong_s:
                seen = f"{sender} tells of {told.level} {told.item}, and {stock[told.item]} lie there"
                raise InvariantBroken(28, at_s, seen)
            self._judge_filling(key, told, at_s, goes_on=goes_on)
            self._judge(key, told, at_s)

    def _is_unread(self, station: str) -> bool:
        """Whether a vehicle at its dock keeps a station from learning by the level of a controller what lies there."""
        node = self._factory.plant.node_of(station)
        return self._factory.has_levels and any(
            vehicle.sense().node == node for vehicle in self._factory.vehicles.values()
        )

    def _note_orders(self, message: StationHeartbeat) -> None:
        """Note orders of earlier lives that this life learns of later than from its journal."""
        station, life = message.station, message.incarnation
        is_first = self._lives.get(station) != life
        self._lives[station] = life
        for brief in message.tasks:
            task = station, brief.task
            if not is_first and brief.destination == station and self._told.get(task, life) != life:
                self._heard_of[station, brief.item] += brief.quantity
            self._told[task] = life

    def _judge_filling(self, key: tuple[str, str], told: StockLevel, at_s: float, *, goes_on: bool) -> None:
        before, storage = self._last.get(key, told), self._storages[key[0]]
        refills = storage.refills[told.item]
        is_new, self._filled[key] = refills != self._filled.get(key, 0), refills
        if not is_new or not goes_on or self._factory.has_levels or before.wanted or told.wanted:
            return
        lay, on_order = storage.filled[told.item], min(before.on_order, told.on_order)
        if lay + on_order > told.capacity:
            seen = f"{key[0]} has filled itself to {lay} {told.item} with {on_order} on order, and has room for {told.capacity}"
            raise InvariantBroken(28, at_s, seen)

    def _judge(self, key: tuple[str, str], told: StockLevel, at_s: float) -> None:
        before, total = self._last.get(key, told), told.level + told.on_order
        self._last[key] = told
        if heard_of := min(self._heard_of[key], max(0, told.on_order - before.on_order)):
            self._heard_of[key] -= heard_of
            self._unasked[key] += max(0, min(heard_of, total - told.capacity))
        if told.on_order <= before.on_order:
            self._unasked[key] += max(0, total - before.level - before.on_order)
        if total <= told.capacity:
            del self._unasked[key]
        elif told.on_order > before.on_order and total > told.capacity + self._unasked[key]:
            seen = f"{key[0]} has {told.level} {key[1]} and {told.on_order} on order, with room for {told.capacity}"
            raise InvariantBroken(28, at_s, seen)
