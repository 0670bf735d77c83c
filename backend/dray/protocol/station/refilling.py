"""A storage has itself refilled: vehicles fetch what it orders from source warehouses (paper, section 1 and Figure 1).

    reorder point: level - asked for + on its way <= point  -->  one lot more, if it finds room

What it orders it coordinates like everything that is brought to it (`transports.transport_flow`): set aside at the warehouses, bid for,
counted as it is put down. What is on its way is what its transports say, and nothing else is counted; so an order that is lost is made
again, and one that is known to anybody is not made twice. Parts come from whoever makes them.
"""

from __future__ import annotations

from collections.abc import Container
from typing import Protocol

from dray.messages import Transport
from dray.plant import Plant
from dray.plant.model import Storage
from dray.protocol.runtime.running import life_mark
from dray.protocol.transports.lead_time import first_lead_s
from dray.protocol.transports.reservations import Reservations

UNHURRIED = 2.0
"""What nobody waits for is due in so many times the time that it takes: vehicles do first what machines wait for."""


class Flow(Protocol):
    """What is needed of a place's material flow."""

    def seek(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        """Have a load set aside, and then fetched."""

    def inbound(self, item: str) -> int:
        """Pieces that are on their way to this place, or are to be."""


class Refilling:
    """What one storage orders by itself; nothing where something else refills it.

    Args:
        storage: as the plant has it.
        plant: who supplies what.
        book: what lies there, and what of it is asked for.
        flow: has loads set aside and fetched.
        incarnation: how often its station was started: no two lives give the same names to transports.
    """

    def __init__(
        self, storage: Storage, plant: Plant, book: Reservations, flow: Flow, incarnation: int
    ) -> None:
        self._storage, self._plant, self._book, self._flow = storage, plant, book, flow
        self._names = f"{storage.id}{life_mark(incarnation)}-refill"
        self._count = 0
        self._rules: dict[str, tuple[int, int]] = {}
        """By material: its reorder point, and the pieces that are ordered at once."""
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
        """Order what is short; of what nobody has counted nobody knows whether it is."""
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
        # Who is asked for more than lies there cannot wait until a whole lot finds room.
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
