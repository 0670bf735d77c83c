"""The data of a shift report: sums over a time, and the worst cases. Each query reads the rows of the time, and returns few."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec
from sqlalchemy import ColumnElement, and_, case, func, or_, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.audit import LINE, AuditRow
from dray.store.orders.progress import OPEN, OrderStatus
from dray.store.orders.tasks import tasks
from dray.store.replay.spells import Spell
from dray.store.replay.tables import spells
from dray.store.tables import audit, orders, people


class OrderCounts(msgspec.Struct, frozen=True, gc=False):
    """Orders of a time."""

    delivered: int
    late: int
    """Delivered orders that were late."""
    open: int
    """Released, and neither delivered nor cancelled at the end of the time."""
    overdue: int
    """Open orders that were overdue."""


class LateOrder(msgspec.Struct, frozen=True, gc=False):
    """An order that was late in a time."""

    id: str
    reference: str | None
    due_at_s: float
    delivered_at_s: float | None
    """None when it had not been delivered by the end of the time."""


class Use(msgspec.Struct, frozen=True, gc=False):
    """One agent's total time of one activity in a time, in wall seconds, and the number of spells."""

    agent: str
    doing: str
    spent_s: float
    spells: int


class Shifts:
    """The reads, inside one transaction. All times are wall clock."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def orders(self, since_s: float, until_s: float) -> OrderCounts:
        """The numbers of orders delivered in a time, and open at its end."""
        c = orders.c
        query = select(func.count(), func.count(case((c.delivered_at_s > c.due_at_s, 1)))).where(
            c.status == OrderStatus.DELIVERED.value, _in(c.delivered_at_s, since_s, until_s)
        )
        delivered, late = (await self._connection.execute(query)).one()
        query = select(func.count(), func.count(case((c.due_at_s <= until_s, 1)))).where(_open_at(until_s))
        still_open, overdue = (await self._connection.execute(query)).one()
        return OrderCounts(delivered, late, still_open, overdue)

    async def late_orders(self, since_s: float, until_s: float, limit: int) -> list[LateOrder]:
        """Orders that were delivered late, or were overdue at the end; the latest first."""
        c = orders.c
        columns = c.id, c.reference, c.due_at_s, c.delivered_at_s
        late_s = case((c.delivered_at_s < until_s, c.delivered_at_s), else_=until_s) - c.due_at_s
        found: list[LateOrder] = []
        for condition in (
            and_(_in(c.delivered_at_s, since_s, until_s), c.delivered_at_s > c.due_at_s),
            and_(_open_at(until_s), c.due_at_s <= until_s),
        ):
            query = select(*columns).where(condition).order_by(late_s.desc(), c.id).limit(limit)
            found += [LateOrder(*row) for row in await self._connection.execute(query)]
        told = [
            msgspec.structs.replace(each, delivered_at_s=None)
            if each.delivered_at_s is not None and each.delivered_at_s >= until_s
            else each
            for each in found
        ]
        return sorted(told, key=lambda each: each.due_at_s - (each.delivered_at_s or until_s))[:limit]

    async def transport_times_s(
        self, since_s: float, until_s: float, longest_s: float, parts: Sequence[float]
    ) -> list[float]:
        """Quantiles of the duration of transports that were handed over in a time, in wall seconds; empty without any.

        Args:
            since_s: the beginning of the time.
            until_s: its end.
            longest_s: transports announced longer before the beginning are left out.
            parts: the quantiles; 0.5 is the median. Each is the duration of one of the transports (nearest rank).
        """
        c = tasks.c
        took_s = c.closed_at_s - c.opened_at_s
        handed_over = (
            c.state == "delivered",
            _in(c.opened_at_s, since_s - longest_s, until_s),
            _in(c.closed_at_s, since_s, until_s),
            c.kind == "transport",
        )
        count = (await self._connection.execute(select(func.count()).where(*handed_over))).scalar_one()
        if count == 0:
            return []
        ranked = select(took_s).where(*handed_over).order_by(took_s).limit(1)
        ranks = [max(0, math.ceil(part * count) - 1) for part in parts]
        return [(await self._connection.execute(ranked.offset(rank))).scalar_one() for rank in ranks]

    async def interventions(
        self, since_s: float, until_s: float, actions: Sequence[str], limit: int
    ) -> tuple[int, list[tuple[AuditRow, str]]]:
        """The number of people's actions of these kinds, and the last of them with the role of each, oldest first."""
        c = audit.c
        done = (
            _in(c.at_s, since_s, until_s),
            c.action.in_(actions),
            c.result == "done",
            c.who_kind.in_(("person", "admin")),
        )
        count = (await self._connection.execute(select(func.count()).where(*done))).scalar_one()
        rows = await self._connection.execute(
            select(*LINE, people.c.role)
            .outerjoin(people, and_(people.c.id == c.who, c.who_kind == "person"))
            .where(*done)
            .order_by(c.position.desc())
            .limit(limit)
        )
        told: list[tuple[AuditRow, str]] = []
        for row in rows:
            fields = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name
            role = fields.pop("role") or fields["who_kind"]
            told.append((AuditRow(**fields | {"detail": msgspec.Raw(fields["detail"].encode())}), role))
        return count, told[::-1]

    async def uses(self, since_s: float, until_s: float, longest_s: float) -> list[Use]:
        """The activities of every vehicle and machine, by agent and activity.

        Args:
            since_s: the beginning of the time.
            until_s: its end.
            longest_s: maximum length of a spell.
        """
        c = spells.c
        begin_s = case((c.from_at_s > since_s, c.from_at_s), else_=since_s)
        end_s = case((c.until_at_s < until_s, c.until_at_s), else_=until_s)
        query = (
            select(c.agent, c.doing, func.sum(end_s - begin_s), func.count())
            .where(_touching(since_s, until_s, longest_s))
            .group_by(c.agent, c.doing)
            .order_by(c.agent, c.doing)
        )
        return [Use(*row) for row in await self._connection.execute(query)]

    async def worst(
        self, doing: str, since_s: float, until_s: float, longest_s: float, limit: int
    ) -> list[Spell]:
        """The longest spells of one activity, the longest first."""
        c = spells.c
        columns = [c[name] for name in Spell.__struct_fields__]
        query = (
            select(*columns)
            .where(_touching(since_s, until_s, longest_s), c.doing == doing)
            .order_by((c.until_at_s - c.from_at_s).desc(), c.position)
            .limit(limit)
        )
        return [Spell(**row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001


def _in(
    column: ColumnElement[float] | ColumnElement[float | None], since_s: float, until_s: float
) -> ColumnElement[bool]:
    return and_(column >= since_s, column < until_s)


def _open_at(until_s: float) -> ColumnElement[bool]:
    """The condition that an order was open then: only open orders, and those changed since, can have been."""
    c = orders.c
    return and_(
        or_(c.status.in_([each.value for each in OPEN]), c.updated_at_s >= until_s),
        c.released_at_s < until_s,
        or_(c.delivered_at_s.is_(None), c.delivered_at_s >= until_s),
        or_(c.cancelled_at_s.is_(None), c.cancelled_at_s >= until_s),
        c.status != OrderStatus.STORED.value,
    )


def _touching(since_s: float, until_s: float, longest_s: float) -> ColumnElement[bool]:
    c = spells.c
    return and_(c.until_at_s > since_s, c.until_at_s <= until_s + longest_s, c.from_at_s < until_s)
