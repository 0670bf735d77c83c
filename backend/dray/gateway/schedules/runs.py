"""Runs: a schedule's request at one moment, a transport or an order, before and while it is stored.

It is stored in the transaction that advances its schedule, under a key made of both. The factory is told once
that is on disk. If this process dies in between, the keepers of transports and orders tell it later.
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
        """Id of the transport or order."""

    @property
    def action(self) -> str:
        """Its name in the audit log."""

    def of(self, row: ScheduleRow, placed: str) -> ScheduleRow:
        """The schedule with this run's id as its last result."""

    async def known(self, work: Work, key: str) -> str | None:
        """The id placed under its key before, or None."""

    async def keep(self, work: Work, key: str) -> None:
        """Store it in a transaction.

        Raises:
            Problem: it cannot be taken now; the transaction must be rolled back.
        """

    def begin(self) -> None:
        """Tell the factory, once it is on disk."""


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
        """A schedule's request at a moment; it counts to its owner's share within the context.

        Args:
            row: the schedule.
            begin_s: the moment, or the time of a late run; wall clock.

        Raises:
            Problem: it names something unknown, or too many are open.
        """
        if row.order_draft:
            draft = RecurringOrder.model_validate_json(row.order_draft).draft(begin_s)
            with self._orders.order(draft, _whose(row)) as order:
                yield _OrderRun(self._orders, order)
            return
        transport = msgspec.structs.replace(self._transport(row), caller=_whose(row))
        yield _TransportRun(self._transports, transport)

    def check(self, row: ScheduleRow, now_s: float) -> None:
        """Refuse an impossible request, without looking at what is open: its first moment may be next week.

        Raises:
            Problem: names the fields of the schedule.
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
    """The principal of a schedule's requests."""
    scope = Scope.ORDERS_WRITE if row.order_draft else Scope.TRANSPORTS_CALL
    return Principal(kind="schedule", id=row.id, name=row.name, scopes=frozenset({scope}))


def _whose(row: ScheduleRow) -> str:
    """The owner of a schedule's requests, whose share they use, for all the owner's schedules together."""
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
