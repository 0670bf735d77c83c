"""Orders in SQL: placing, finding, and updating them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import islice

import msgspec
from sqlalchemy import ColumnElement, Row, bindparam, func, insert, or_, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.priorities import Priority
from dray.store.database.counting import total_of
from dray.store.database.searching import searched
from dray.store.orders.order_filter import OrderFilter
from dray.store.orders.order_sorting import NEWEST_FIRST, Place, Sorting
from dray.store.orders.progress import OPEN, UNENDED, OrderStatus, Progress, delivered_after, status_after
from dray.store.tables import goals, order_items, orders

AT_ONCE = 50
"""Orders whose items are read at once: some milliseconds of the event loop, however many items they have."""

Mark = tuple[OrderStatus, int, float | None, int, int]
"""The part of an order that every decision of a person or the strategist changes: its status, number of releases, time of
revocation, number of changes, and last accepted change."""


class Item(msgspec.Struct, gc=False):
    """A line of an order."""

    product: str
    quantity: int
    made: int = 0
    delivered: int = 0
    wanted: int | None = None
    """The smaller quantity of a change in progress; None without one."""


class Order(msgspec.Struct, kw_only=True, gc=False):
    """An order with its items. Times are wall clock seconds."""

    id: str
    status: OrderStatus
    customer: str
    token: str
    """The token of the link to its customer's page; `tracking_links` has the link's validity."""
    items: tuple[Item, ...]
    created_at_s: float
    reference: str | None = None
    due_at_s: float | None = None
    released_at_s: float | None = None
    cancelled_at_s: float | None = None
    delivered_at_s: float | None = None
    incarnation: int = 0
    """The newest life of the strategist that has accepted it."""
    releases: int = 0
    """Number of releases."""
    revoked_at_s: float | None = None
    """The time of the last release's revocation; the factory confirms it when the order is stored."""
    updated_at_s: float = 0.0
    """The time of its last visible change."""
    priority: Priority = Priority.NORMAL
    wanted_at_s: float | None = None
    """The wanted time for agents, from its priority and due time; None before its first release."""
    change: int = 0
    """Number of changes."""
    change_taken: int = 0
    """The last change that the strategist has accepted, or need not know."""
    caller: str = ""
    """Kind and id of the caller that placed it; empty if unknown."""

    @property
    def quantities(self) -> tuple[int, ...]:
        """Pieces ordered, per item."""
        return tuple(item.quantity for item in self.items)

    @property
    def wanted(self) -> tuple[int, ...]:
        """The same, with the change in progress."""
        return tuple(item.quantity if item.wanted is None else item.wanted for item in self.items)

    @property
    def delivered(self) -> tuple[int, ...]:
        """Pieces that have arrived, per item."""
        return tuple(item.delivered for item in self.items)

    @property
    def mark(self) -> Mark:
        """See `Mark`."""
        return self.status, self.releases, self.revoked_at_s, self.change, self.change_taken

    @property
    def being_changed(self) -> bool:
        """Whether its last change is unconfirmed."""
        return self.change_taken < self.change and self.status in OPEN

    @property
    def being_revoked(self) -> bool:
        """Whether its revocation is unconfirmed."""
        return self.status in OPEN and self.revoked_at_s is not None

    @property
    def outstanding(self) -> tuple[int, ...]:
        """Pieces still to be delivered, per item."""
        return tuple(item.quantity - item.delivered for item in self.items)

    @property
    def wanted_outstanding(self) -> tuple[int, ...]:
        """The same, with the change in progress."""
        return tuple(
            max(0, each - item.delivered) for each, item in zip(self.wanted, self.items, strict=True)
        )

    def strange_to(self, products: Collection[str]) -> list[str]:
        """Its products that are not among these, by id."""
        return sorted({item.product for item in self.items}.difference(products))


class OrderTotals(msgspec.Struct, frozen=True, gc=False):
    """Counts over all orders ever."""

    delivered: int
    on_time: int
    """Orders delivered by their due time; an order without one is never late."""


_COLUMNS = [column for column in orders.c if column.name != "search"]


REFERENCES_AT_ONCE = 100
"""References per statement: a millisecond or two of the event loop."""

REFERRED_MOST = 1_000
"""Maximum orders found: a file placed within the hour has no more, and the newest ones matter."""


class Referred(msgspec.Struct, frozen=True):
    """An order by its customer's reference."""

    id: str
    customer: str
    reference: str
    created_at_s: float
    """Wall clock."""

    def values(self, now_s: float) -> dict[str, str | int]:
        """The values for a hint; `now_s` is wall clock."""
        minutes = max(0, round((now_s - self.created_at_s) / 60.0))
        return {"customer": self.customer, "order": self.id, "minutes": minutes}


class Orders:
    """The orders, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, order: Order) -> None:
        """Store a new order."""
        await self.add_all([order])

    async def add_all(self, new: Sequence[Order]) -> None:
        """Store new orders."""
        if not new:
            return
        await self._connection.execute(insert(orders), rows_of_orders(new))
        await self._connection.execute(insert(order_items), rows_of_items(new))

    async def get(self, order_id: str) -> Order | None:
        """One order, or None."""
        if "\0" in order_id:  # PostgreSQL supports no such text, and refuses the query.
            return None
        return next(iter(await self._select(orders.c.id == order_id)), None)

    async def many(self, ids: Iterable[str]) -> list[Order]:
        """The orders with these ids, if they exist, unordered."""
        wanted = list(ids)
        return await self._select(orders.c.id.in_(wanted)) if wanted else []

    async def references(self, ids: Collection[str]) -> dict[str, str]:
        """The customers' references of these orders, where they have one."""
        return {order: name for order, name in (await self.names(ids)).items() if name is not None}

    async def names(self, ids: Collection[str]) -> dict[str, str | None]:
        """The orders among these ids, each with its customer's reference."""
        if not ids:
            return {}
        query = select(orders.c.id, orders.c.reference).where(orders.c.id.in_(list(ids)))
        return {row.id: row.reference for row in await self._connection.execute(query)}

    async def referred_to(self, references: Collection[str], since_s: float) -> list[Referred]:
        """Orders placed since then under some references and not cancelled; for each reference oldest first.

        The limits are `REFERENCES_AT_ONCE` references and the newest `REFERRED_MOST` orders.
        """
        found: list[Referred] = []
        left = iter(references)
        while some := list(islice(left, REFERENCES_AT_ONCE)):
            query = (
                select(orders.c.id, orders.c.customer, orders.c.reference, orders.c.created_at_s)
                .where(
                    orders.c.created_at_s >= since_s,
                    orders.c.reference.in_(some),
                    orders.c.status != OrderStatus.CANCELLED,
                )
                .order_by(orders.c.created_at_s.desc(), orders.c.id.desc())
                .limit(REFERRED_MOST)
            )
            rows = (await self._connection.execute(query)).all()
            found += [Referred(*row) for row in reversed(rows)]
        return found

    async def newest_references(self, customer: str, caller: str, count: int) -> list[str]:
        """The references of the newest orders of a customer by one caller, newest first.

        Args:
            customer: the customer.
            caller: kind and id of the caller; empty for unknown.
            count: maximum number of references.
        """
        query = (
            select(orders.c.reference)
            .where(orders.c.customer == customer, orders.c.caller == caller, orders.c.reference.is_not(None))
            .order_by(orders.c.created_at_s.desc(), orders.c.id.desc())
            .limit(count)
        )
        return list((await self._connection.execute(query)).scalars())

    async def open(self) -> list[Order]:
        """All orders that the factory works at, oldest first."""
        found = await self._select(orders.c.status.in_(OPEN))
        return sorted(found, key=lambda order: (order.created_at_s, order.id))

    async def marks(self, since_s: float | None = None) -> dict[str, Mark]:
        """The marks of all orders that have not ended; or of all those changed since then."""
        names = ("id", "status", "releases", "revoked_at_s", "change", "change_taken")
        wanted = orders.c.status.in_(UNENDED) if since_s is None else orders.c.updated_at_s >= since_s
        rows = await self._connection.execute(select(*(orders.c[name] for name in names)).where(wanted))
        return {order: (OrderStatus(status), *others) for order, status, *others in rows}

    async def newest_change_s(self) -> float:
        """The time of the last change of any order; 0 without orders."""
        return await self._connection.scalar(select(func.max(orders.c.updated_at_s))) or 0.0

    async def cancelled(self, since_s: float) -> list[str]:
        """Ids of released orders that were cancelled since then, the oldest first."""
        query = (
            select(orders.c.id)
            .where(
                orders.c.status == OrderStatus.CANCELLED,
                orders.c.released_at_s.is_not(None),
                orders.c.cancelled_at_s >= since_s,
            )
            .order_by(orders.c.cancelled_at_s, orders.c.id)
        )
        return list((await self._connection.execute(query)).scalars())

    async def page(
        self, wanted: OrderFilter, after: Place | None, limit: int | None, sorting: Sorting = NEWEST_FIRST
    ) -> list[Order]:
        """A part of a list, newest first by default.

        Args:
            wanted: the filter.
            after: the place (`Sorting.place`) of the previous page's last order.
            limit: maximum number of orders.
            sorting: the sort order.
        """
        conditions = list(wanted.conditions())
        if after is not None:
            conditions.append(sorting.after(after))
        return await self._select(*conditions, limit=limit, sorting=sorting)

    async def total(self, wanted: OrderFilter) -> int | None:
        """The number of matching orders; None for very many."""
        return await total_of(self._connection, select(orders.c.id).where(*wanted.conditions()))

    async def totals(self) -> OrderTotals:
        """Count deliveries."""
        punctual = or_(orders.c.due_at_s.is_(None), orders.c.delivered_at_s <= orders.c.due_at_s)
        row = (
            await self._connection.execute(
                select(func.count(), func.count().filter(punctual)).where(
                    orders.c.status == OrderStatus.DELIVERED
                )
            )
        ).one()
        return OrderTotals(row[0], row[1])

    async def release(self, order_id: str, at_s: float, wanted_at_s: float) -> None:
        """Release a stored order to the factory, with its wanted time; any other stays as it is."""
        await self._connection.execute(
            update(orders)
            .where(orders.c.id == order_id, orders.c.status == OrderStatus.STORED)
            .values(
                status=OrderStatus.RELEASED,
                released_at_s=at_s,
                wanted_at_s=wanted_at_s,
                releases=orders.c.releases + 1,
                revoked_at_s=None,
                updated_at_s=at_s,
            )
        )

    async def revoke(self, order_id: str, at_s: float) -> None:
        """Note the revocation of an open order; any other stays as it is."""
        await self._connection.execute(
            update(orders)
            .where(orders.c.id == order_id, orders.c.status.in_(OPEN), orders.c.revoked_at_s.is_(None))
            .values(revoked_at_s=at_s, updated_at_s=at_s)
        )

    async def store(self, order_id: str, release: int, outstanding: Sequence[int], at_s: float) -> None:
        """The factory has stopped work on a revoked order; if it is too late, the order is delivered.

        Args:
            order_id: the order; one that is not being revoked, or was released again, stays as it is.
            release: the release concerned.
            outstanding: per item, pieces that had not arrived by then; empty for unknown.
            at_s: the time of the message.
        """
        order = await self.get(order_id)
        if order is None or not order.being_revoked or order.releases != release:
            return
        arrived = [
            (index, item.quantity - left)
            for index, (item, left) in enumerate(zip(order.items, outstanding, strict=False))
        ]
        for index, pieces in arrived:
            await self._connection.execute(
                update(order_items)
                .where(
                    order_items.c.order_id == order_id,
                    order_items.c.item == index,
                    order_items.c.delivered < pieces,
                )
                .values(delivered=pieces)
            )
        too_late = bool(outstanding) and not any(outstanding)
        after: dict[str, object] = {"revoked_at_s": None} if too_late else {"status": OrderStatus.STORED}
        await self._connection.execute(
            update(orders).where(orders.c.id == order_id).values(after | {"updated_at_s": at_s})
        )
        if too_late:
            await self.fulfil(order_id, release, at_s)

    async def fulfil(self, order_id: str, release: int, at_s: float) -> None:
        """The factory reports that all of an order has arrived, whatever facts say.

        Args:
            order_id: the order; one that has ended, is stored or being revoked, or was released again stays
                as it is.
            release: the release concerned.
            at_s: the time of the message; it becomes the delivery time without any fact of a delivery.
        """
        order = await self.get(order_id)
        if order is None or order.status not in OPEN or order.being_revoked or order.releases != release:
            return
        told = select(func.max(goals.c.delivered_at_s)).where(goals.c.order_id == order_id)
        told_s = await self._connection.scalar(told)
        delivered_at_s = at_s if told_s is None else told_s
        all_of_it = order.quantities
        reached = Progress(OrderStatus.DELIVERED, all_of_it, all_of_it, delivered_at_s)
        await self.advance(order, reached, at_s)

    async def cancel(self, order_id: str, at_s: float) -> None:
        """Cancel an undelivered order; any other stays as it is."""
        await self._connection.execute(
            update(orders)
            .where(orders.c.id == order_id, orders.c.status.in_(UNENDED))
            .values(status=OrderStatus.CANCELLED, cancelled_at_s=at_s, updated_at_s=at_s)
        )

    async def accept(self, incarnations: dict[str, int]) -> None:
        """Note the life of the strategist that has accepted each order; an older life changes nothing."""
        if incarnations:
            await self._connection.execute(
                update(orders)
                .where(orders.c.id == bindparam("of"), orders.c.incarnation < bindparam("life"))
                .values(incarnation=bindparam("life")),
                [{"of": order, "life": life} for order, life in incarnations.items()],
            )

    async def advance(self, order: Order, progress: Progress, at_s: float) -> None:
        """Store an order's progress, by `status_after`.

        Args:
            order: as it was read.
            progress: the progress by its goals.
            at_s: the wall clock now.
        """
        status = status_after(order.status, progress.status)
        delivered_at_s = delivered_after(status, order.delivered_at_s, progress.delivered_at_s)
        changed = [
            {"of": order.id, "at": index, "made": made, "delivered": delivered}
            for index, (item, made, delivered) in enumerate(
                zip(order.items, progress.made, progress.delivered, strict=True)
            )
            if (item.made, item.delivered) != (made, delivered)
        ]
        if changed or (status, delivered_at_s) != (order.status, order.delivered_at_s):
            await self._connection.execute(
                update(orders)
                # A person may have revoked or cancelled it since it was read.
                .where(orders.c.id == order.id, orders.c.status == order.status)
                .values(status=status, delivered_at_s=delivered_at_s, updated_at_s=at_s)
            )
        if changed:
            await self._connection.execute(
                update(order_items)
                .where(order_items.c.order_id == bindparam("of"), order_items.c.item == bindparam("at"))
                .values(made=bindparam("made"), delivered=bindparam("delivered")),
                changed,
            )

    async def _select(
        self, *conditions: ColumnElement[bool], limit: int | None = None, sorting: Sorting = NEWEST_FIRST
    ) -> list[Order]:
        query = select(*_COLUMNS).where(*conditions).order_by(*sorting.clauses()).limit(limit)
        rows = (await self._connection.execute(query)).all()
        lines: dict[str, list[Item]] = {row.id: [] for row in rows}
        names = list(lines)
        for at in range(0, len(names), AT_ONCE):
            for line in await self._connection.execute(
                select(order_items)
                .where(order_items.c.order_id.in_(names[at : at + AT_ONCE]))
                .order_by(order_items.c.order_id, order_items.c.item)
            ):
                item = Item(line.product, line.quantity, line.made, line.delivered, line.wanted)
                lines[line.order_id].append(item)
        return [_order(row, lines[row.id]) for row in rows]


def rows_of_orders(new: Sequence[Order]) -> list[dict[str, object]]:
    """New orders as rows of their table."""
    rows = []
    for order in new:
        row = msgspec.structs.asdict(order)
        del row["items"]
        updated_at_s = max(order.updated_at_s, order.created_at_s)
        rows.append(row | {"updated_at_s": updated_at_s, "search": search_of(order)})
    return rows


def rows_of_items(new: Sequence[Order]) -> list[dict[str, object]]:
    """Their items as rows of their table."""
    return [
        {"order_id": order.id, "item": index, **msgspec.structs.asdict(item)}
        for order in new
        for index, item in enumerate(order.items)
    ]


def search_of(order: Order) -> str:
    """An order's search text."""
    products = [item.product for item in order.items]
    return searched((order.id, order.reference or "", order.customer), products)


def _order(row: Row[tuple[object, ...]], items: list[Item]) -> Order:
    fields = dict(row._mapping)  # noqa: SLF001 - SQLAlchemy's public name for it
    fields["status"], fields["priority"] = OrderStatus(fields["status"]), Priority(fields["priority"])
    return Order(items=tuple(items), **fields)
