"""Runs: what a schedule asks for at one moment, a transport or an order, before and when it is kept.

It is kept in the transaction in which its schedule moves on, under a key that is made of both; what is to be told to the factory is told
when that is on disk, and told again by who keeps transports and orders, should this process die in between.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

import msgspec

from dray.gateway.access.principal import Principal, Scope
from dray.gateway.http.problems import Problem, unusable
from dray.gateway.orders.placement import OrderPlacement
from dray.gateway.orders.transport_draft import TransportDraft
from dray.gateway.orders.transports import PlainTransports
from dray.gateway.schedules.drafts import RecurringOrder
from dray.store.orders.orders import Order
from dray.store.orders.schedules import ScheduleRow
from dray.store.orders.transports import TransportRow
from dray.store.work import Work


class Run(Protocol):
    """The work of one moment."""

    @property
    def id(self) -> str:
        """Of the transport or order."""

    @property
    def action(self) -> str:
        """What the audit log calls it."""

    def of(self, row: ScheduleRow, placed: str) -> ScheduleRow:
        """The schedule, once this is what came of its last moment under some id."""

    async def known(self, work: Work, key: str) -> str | None:
        """The id of what was placed under its key before, or None."""

    async def keep(self, work: Work, key: str) -> None:
        """Keep it, in a transaction.

        Raises:
            Problem: it cannot be taken now; the transaction is to be undone.
        """

    def begin(self) -> None:
        """Tell the factory of it; it is on disk."""


class Runs:
    """Makes the runs of schedules.

    Args:
        transports: takes transports.
        orders: takes orders.
    """

    def __init__(self, transports: PlainTransports, orders: OrderPlacement) -> None:
        self._transports, self._orders = transports, orders

    @contextmanager
    def run(self, row: ScheduleRow, begin_s: float) -> Iterator[Run]:
        """What a schedule asks for at a moment; it counts to its owner's share as long as the context lasts.

        Args:
            row: the schedule.
            begin_s: the moment, or when it is made up for; wall clock.

        Raises:
            Problem: it names what does not exist, or too many are open.
        """
        if row.order_draft:
            draft = RecurringOrder.model_validate_json(row.order_draft).draft(begin_s)
            with self._orders.order(draft, _whose(row)) as order:
                yield _OrderRun(self._orders, order)
            return
        transport = msgspec.structs.replace(self._transport(row), caller=_whose(row))
        yield _TransportRun(self._transports, transport)

    def check(self, row: ScheduleRow, now_s: float) -> None:
        """Refuse what could not be done now, however much is open: its first moment may be next week.

        Raises:
            Problem: names the fields as a schedule has them.
        """
        try:
            if row.order_draft:
                self._orders.check(RecurringOrder.model_validate_json(row.order_draft).draft(now_s))
            else:
                self._transport(row)
        except Problem as problem:
            if not problem.errors:
                raise
            part = "order" if row.order_draft else "transport"
            raise unusable(
                *(msgspec.structs.replace(each, field=f"{part}.{each.field}") for each in problem.errors)
            ) from None

    def _transport(self, row: ScheduleRow) -> TransportRow:
        return self._transports.row(TransportDraft.model_validate_json(row.transport), principal(row))


def principal(row: ScheduleRow) -> Principal:
    """Who asks for what a schedule asks for."""
    scope = Scope.ORDERS_WRITE if row.order_draft else Scope.TRANSPORTS_CALL
    return Principal(kind="schedule", id=row.id, name=row.name, scopes=frozenset({scope}))


def _whose(row: ScheduleRow) -> str:
    """Whose it is what it asks for, and whose share that takes: its owner's, however many schedules that one has."""
    return row.owner or principal(row).key


class _TransportRun:
    action = "transport.call"

    def __init__(self, transports: PlainTransports, row: TransportRow) -> None:
        self._transports, self._row, self.id = transports, row, row.id

    def of(self, row: ScheduleRow, placed: str) -> ScheduleRow:
        return msgspec.structs.replace(row, last_transport=placed)

    async def known(self, work: Work, key: str) -> str | None:
        row = await work.transports.of_key(key)
        return None if row is None else row.id

    async def keep(self, work: Work, key: str) -> None:
        await self._transports.keep(work, msgspec.structs.replace(self._row, key=key))

    def begin(self) -> None:
        self._transports.ask(self._row)


class _OrderRun:
    action = "order.place"

    def __init__(self, orders: OrderPlacement, order: Order) -> None:
        self._orders, self._order, self.id = orders, order, order.id

    def of(self, row: ScheduleRow, placed: str) -> ScheduleRow:
        return msgspec.structs.replace(row, last_order=placed)

    async def known(self, work: Work, key: str) -> str | None:
        kept = await work.keys.get(key)
        return None if kept is None else kept.order_id

    async def keep(self, work: Work, key: str) -> None:
        await self._orders.keep(work, self._order, key)

    def begin(self) -> None:
        self._orders.publish(self._order)
