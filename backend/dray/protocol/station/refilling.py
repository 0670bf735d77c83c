"""Refill orders of a storage: vehicles fetch them from source warehouses (paper, section 1 and Figure 1).

    reorder point: level - requested + inbound <= point  -->  one lot more, if there is room

The storage coordinates its orders like all transports to it (`transports.transport_flow`): set aside at the
warehouses, bid for, and counted when put down. Only its transports tell what is inbound. So a lost order is
repeated, and a known one is never doubled. Parts come from their makers.
"""

from __future__ import annotations

from collections.abc import Container
from typing import Protocol

from dray.messages import Transport
from dray.plant import Plant
from dray.plant.model import Storage
from dray.protocol.runtime.life import Life
from dray.protocol.transports.lead_time import first_lead_s
from dray.protocol.transports.reservations import Reservations

UNHURRIED = 2.0
"""Deadline factor of refills that no machine waits for: vehicles serve waiting machines first."""


class Flow(Protocol):
    """What this class needs of a place's material flow."""

    def seek(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        """Have a load set aside, and then fetched."""

    def inbound(self, item: str) -> int:
        """Pieces that are to find room here: on order, or put down without an order."""


class Refilling:
    """The orders of one storage; none if something else refills it.

    Args:
        storage: the plant's storage.
        plant: the suppliers of materials.
        book: its stock and reservations.
        flow: has loads set aside and fetched.
        life: its station's life; transport names differ between lives.
    """

    def __init__(self, storage: Storage, plant: Plant, book: Reservations, flow: Flow, life: Life) -> None:
        self._storage, self._plant, self._book, self._flow = storage, plant, book, flow
        self._names = f"{storage.id}{life.mark}-refill"
        self._count = 0
        self._rules: dict[str, tuple[int, int]] = {}
        """By material: its reorder point, and the pieces of one order."""
        if storage.refill == "vehicles":
            for kept in storage.stocks:
                if plant.supplies_of(kept.material):
                    lot = kept.lot or plant.materials[kept.material].lot
                    point = min(kept.capacity // 2, kept.capacity - lot)
                    self._rules[kept.material] = (
                        point if kept.reorder_point is None else kept.reorder_point,
                        lot,
                    )

    def pursue(self, now_s: float, uncounted: Container[str]) -> None:
        """Order missing pieces; uncounted materials are not ordered."""
        for item in self._rules:
            while item not in uncounted and (pieces := self._missing(item)):
                self._order(item, pieces, now_s)

    def _missing(self, item: str) -> int:
        """Pieces to order now; 0 for none."""
        point, lot = self._rules[item]
        inbound = self._flow.inbound(item)
        room = self._book.room(item) - inbound
        if self._book.level(item) - self._book.asked(item) + inbound > point:
            return 0
        # A shortage cannot wait until there is room for a whole lot.
        is_short = self._book.asked(item) > self._book.level(item) + inbound
        return lot if lot <= room else max(0, room) if is_short else 0

    def _order(self, item: str, pieces: int, now_s: float) -> None:
        self._count += 1
        place, sources = self._storage.id, self._plant.supplies_of(item)
        work = Transport(
            item=item,
            quantity=pieces,
            sources=sources,
            destination=place,
            ability=self._plant.materials[item].ability,
        )
        takes_s = first_lead_s(self._plant, place, sources)
        waited_for = self._book.asked(item) > self._book.level(item)
        self._flow.seek(
            f"{self._names}-{self._count}", work, now_s + takes_s * (1.0 if waited_for else UNHURRIED), now_s
        )
