"""An order's own history: its pages need the events long after the log has deleted them.

While the log has an order's events they are read there. Before the log deletes any of them, all of them are merged with the stored
history into one compressed document. For a goal only its first and last pieces are needed.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Sequence

import msgspec
from sqlalchemy import and_, delete, func, insert, or_, select, union
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages.fact import (
    CarrierChanged,
    GoalContracted,
    GoalLost,
    GoalWaits,
    GoalWithdrawn,
    GoodsDelivered,
    OrderDropped,
    OrderFulfilled,
    OrderReturned,
    PhaseEntered,
    PieceMade,
    PromiseMoved,
    TaskClosed,
    TaskOpened,
)
from dray.store.history.events import EventFilter, EventRow, Events
from dray.store.orders.milestones import Milestones, OrderTimes, order_histories
from dray.store.orders.tasks import tasks
from dray.store.tables import events, goals

TOLD_BY = (
    *(CarrierChanged, GoalContracted, GoalLost, GoalWaits, GoalWithdrawn, GoodsDelivered, OrderDropped),
    *(OrderFulfilled, OrderReturned, PhaseEntered, PieceMade, PromiseMoved, TaskClosed),
    TaskOpened,
)
"""Facts on an order's page."""

KINDS = tuple(kind.__name__ for kind in TOLD_BY)

ROWS_AT_ONCE = 2_000

_KEPT = msgspec.json.Decoder(list[EventRow])


class OrderHistory(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """The stored history of one order."""

    order_id: str
    position: int
    """The position of its newest event."""
    times: OrderTimes
    told: bytes
    """Its events, as compressed JSON."""


class OrderHistories:
    """The histories of orders, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def of_order(self, order_id: str) -> list[EventRow]:
        """The stored events of an order, unordered; empty while the log has all of them."""
        query = select(order_histories.c.told).where(order_histories.c.order_id == order_id)
        told = (await self._connection.execute(query)).scalar()
        return [] if told is None else _KEPT.decode(zlib.decompress(told))

    async def gathered(self, first: int, last: int) -> list[OrderHistory]:
        """New histories of orders with unstored events at these positions of the log; reading beside writers is safe.

        Pass them to `put` in the transaction that deletes these positions, unless another process has deleted any of them by then.
        """
        return [await self._gathered(order_id) for order_id in await self._unkept(first, last)]

    async def put(self, histories: Sequence[OrderHistory]) -> None:
        """Store these histories, replacing earlier ones."""
        if histories:
            c = order_histories.c
            of = [each.order_id for each in histories]
            await self._connection.execute(delete(order_histories).where(c.order_id.in_(of)))
            rows = [
                {"order_id": each.order_id, "position": each.position, "told": each.told}
                | msgspec.structs.asdict(each.times)
                for each in histories
            ]
            await self._connection.execute(insert(order_histories), rows)

    async def _unkept(self, first: int, last: int) -> list[str]:
        """Orders with events at these positions that their stored histories lack."""
        told = and_(events.c.position.between(first, last), events.c.kind.in_(KINDS))
        named = select(events.c.position, events.c.order_id).where(told, events.c.order_id.is_not(None))
        by_goal = (
            select(events.c.position, goals.c.order_id)
            .join(goals, goals.c.id == events.c.goal)
            .where(told, goals.c.order_id.is_not(None))
        )
        by_task = (
            select(events.c.position, tasks.c.order_id)
            .join(tasks, tasks.c.id == events.c.task)
            .where(told, tasks.c.order_id != "")
        )
        found = union(named, by_goal, by_task).subquery()
        kept = order_histories
        query = (
            select(found.c.order_id)
            .outerjoin(kept, kept.c.order_id == found.c.order_id)
            .where(or_(kept.c.position.is_(None), kept.c.position < found.c.position))
            .distinct()
        )
        return sorted((await self._connection.execute(query)).scalars())

    async def _gathered(self, order_id: str) -> OrderHistory:
        told = {_key(row): row for row in await self.of_order(order_id)}
        log, wanted, after = Events(self._connection), EventFilter(kinds=KINDS, order=order_id), None
        is_more = True
        while is_more:
            rows = await log.page(wanted, after, ROWS_AT_ONCE, newest_first=False)
            told |= {_key(row): row for row in rows}
            is_more = len(rows) == ROWS_AT_ONCE
            after = rows[-1].position if is_more else None
        return OrderHistory(
            order_id=order_id,
            position=max((row.position for row in told.values()), default=0),
            times=await Milestones(self._connection).of_order(order_id),
            told=zlib.compress(msgspec.json.encode(_needed(told.values()))),
        )

    async def count(self) -> int:
        """The number of orders with a stored history."""
        query = select(func.count()).select_from(order_histories)
        return (await self._connection.execute(query)).scalar_one()


def together(kept: Iterable[EventRow], logged: Iterable[EventRow]) -> list[EventRow]:
    """The stored and the logged events of an order, each once."""
    return list({_key(row): row for rows in (kept, logged) for row in rows}.values())


def _key(row: EventRow) -> tuple[str, int, int]:
    return row.agent, row.incarnation, row.number


def _needed(told: Iterable[EventRow]) -> list[EventRow]:
    """All events but the pieces of each goal between the first and the last one."""
    needed: list[EventRow] = []
    pieces: dict[str, list[EventRow]] = {}
    for row in told:
        if row.kind == PieceMade.__name__ and row.goal:
            pieces.setdefault(row.goal, []).append(row)
        else:
            needed.append(row)
    for of_goal in pieces.values():
        of_goal.sort(key=lambda row: (row.plant_s, *_key(row)))
        needed += {_key(row): row for row in (of_goal[0], of_goal[-1])}.values()
    return sorted(needed, key=lambda row: row.position)
