"""How far a storage that fills itself may fill: it leaves room for the loads that are on order to it.

    fill to = capacity - on order; while the material is short: capacity - loads that have a carrier

Loads that vehicles bring back to its dock keep their room, too.

The body keeps the last limit while its station is away. A station that has lost its notes tells none before it has
listened to the carriers of its earlier lives. While vehicles wait here for more than there is, a load that nobody
carries yet keeps no room: its source may be short, too, and the machines must not wait for it.
"""

from __future__ import annotations

from typing import Protocol

from dray.body import FillTo, Refill
from dray.plant import Plant
from dray.plant.model import Storage
from dray.protocol.runtime.life import Life
from dray.protocol.transports.reservations import Reservations


class Flow(Protocol):
    """What this class needs of a place's material flow."""

    @property
    def hears_out(self) -> bool:
        """Whether carriers may still report loads for an earlier life without notes."""

    def inbound(self, item: str) -> int:
        """Pieces that are to find room here: on order, or put down without an order."""

    def carried(self, item: str) -> int:
        """Those of them that have a carrier."""


class SelfFilling:
    """What the body of one storage is told of its filling; nothing if something else refills it.

    Args:
        storage: the plant's storage.
        plant: its parts, which only their makers fill up.
        book: its stock and reservations.
        flow: knows what is on order.
        life: its station's life.
    """

    def __init__(self, storage: Storage, plant: Plant, book: Reservations, flow: Flow, life: Life) -> None:
        self._book, self._flow, self._life = book, flow, life
        self._capacity = {
            kept.material: kept.capacity
            for kept in storage.stocks
            if storage.refill == "itself" and kept.material not in plant.parts
        }
        self._told: dict[str, int] = {}
        """By material: the limit that this life has told last."""

    def pursue(self) -> None:
        """Tell changed limits, and what is short."""
        short = self._book.short_items
        for item, capacity in self._capacity.items():
            if not self._flow.hears_out:
                coming = self._flow.carried(item) if item in short else self._flow.inbound(item)
                self._limit(item, max(0, capacity - coming))
            if item in short:
                self._life.instruct(Refill(item=item))

    def _limit(self, item: str, pieces: int) -> None:
        if self._told.get(item) != pieces:
            self._told[item] = pieces
            self._life.instruct(FillTo(item=item, quantity=pieces))
