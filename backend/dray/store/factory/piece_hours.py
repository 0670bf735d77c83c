"""Pieces made by machines in SQL, good and bad ones, by wall hours.

Each event is counted once, in the transaction that stores it. A repeated event is not counted twice, and a late one counts in its
own hour. The counts remain when events are deleted.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping

import msgspec
from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages import Event
from dray.messages.fact import PieceMade, PieceScrapped, SparePieceMade
from dray.store.history.clocks import ToWall
from dray.store.tables import events, piece_hours

HOUR_S = 3600.0


class PieceCount(msgspec.Struct, frozen=True, gc=False):
    """The pieces of one machine and one product."""

    machine: str
    product: str
    good: int
    bad: int


Made = tuple[float, str, str, bool]
"""Hour, machine, product, and whether the piece is bad."""


class PieceHours:
    """The counts, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, new: Iterable[Event], to_wall_s: ToWall) -> None:
        """Count the pieces in events that are not stored yet; call it before storing them."""
        told = {
            (event.agent, event.incarnation, event.number): made
            for event in new
            if (made := _made(event, to_wall_s)) is not None
        }
        for known in await self._known(told):
            del told[known]
        counts = Counter(told.values())
        for hour_s, machine, product in dict.fromkeys(made[:3] for made in counts):
            good, bad = (counts[hour_s, machine, product, is_bad] for is_bad in (False, True))
            await self._count(hour_s, PieceCount(machine, product, good, bad))

    async def between(self, since_s: float, until_s: float) -> list[PieceCount]:
        """The pieces of the hours that begin at `since_s` or later and before `until_s`, by machine and product."""
        columns = piece_hours.c
        query = (
            select(columns.machine, columns.product, func.sum(columns.good), func.sum(columns.bad))
            .where(columns.hour_s >= since_s, columns.hour_s < until_s)
            .group_by(columns.machine, columns.product)
            .order_by(columns.machine, columns.product)
        )
        rows = await self._connection.execute(query)
        return [PieceCount(machine, product, int(good), int(bad)) for machine, product, good, bad in rows]

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some counts of hours that began before this moment, whole hours each; returns the number."""
        c = piece_hours.c
        oldest = select(c.hour_s).where(c.hour_s < before_s).order_by(c.hour_s).limit(at_most)
        hours = list((await self._connection.execute(oldest)).scalars())
        if not hours:
            return 0
        return (await self._connection.execute(delete(piece_hours).where(c.hour_s <= hours[-1]))).rowcount

    async def _known(self, told: Mapping[tuple[str, int, int], Made]) -> list[tuple[str, int, int]]:
        """The events that are stored already."""
        lives: defaultdict[tuple[str, int], list[int]] = defaultdict(list)
        for agent, incarnation, number in told:
            lives[agent, incarnation].append(number)
        known = []
        for (agent, incarnation), numbers in lives.items():
            query = select(events.c.number).where(
                events.c.agent == agent, events.c.incarnation == incarnation, events.c.number.in_(numbers)
            )
            kept = (await self._connection.execute(query)).scalars()
            known += [(agent, incarnation, number) for number in kept]
        return known

    async def _count(self, hour_s: float, more: PieceCount) -> None:
        key = (
            piece_hours.c.hour_s == hour_s,
            piece_hours.c.machine == more.machine,
            piece_hours.c.product == more.product,
        )
        added = {"good": piece_hours.c.good + more.good, "bad": piece_hours.c.bad + more.bad}
        counted = await self._connection.execute(update(piece_hours).where(*key).values(**added))
        if counted.rowcount == 0:
            row = {"hour_s": hour_s, **msgspec.structs.asdict(more)}
            await self._connection.execute(insert(piece_hours), [row])


def _made(event: Event, to_wall_s: ToWall) -> Made | None:
    """The new piece of an event; None for any other event."""
    fact = event.fact
    if not isinstance(fact, PieceMade | PieceScrapped | SparePieceMade):
        return None
    if isinstance(fact, PieceMade) and fact.from_stock:
        return None
    hour_s = to_wall_s(event.at_s) // HOUR_S * HOUR_S
    return hour_s, event.agent, fact.product, isinstance(fact, PieceScrapped)
