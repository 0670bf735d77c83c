"""Plain transports in SQL: the requests, and their progress.

The destination reports the progress (`TransportProgressed`) in numbered events that come late, doubled and in any order: the newest
counts, and an end is final.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Literal

import msgspec
from sqlalchemy import (
    CheckConstraint,
    Column,
    ColumnElement,
    Double,
    ForeignKey,
    Index,
    Integer,
    Select,
    String,
    Table,
    Text,
    UniqueConstraint,
    delete,
    func,
    insert,
    or_,
    select,
    tuple_,
    update,
)
from sqlalchemy.exc import IntegrityError
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.messages import TRANSPORT_ENDED, Event, TransportState
from dray.messages.fact import TransportProgressed
from dray.messages.overtaken import OVERTAKES_S
from dray.store.database.counting import total_of
from dray.store.database.searching import Sought
from dray.store.history.clocks import ToWall
from dray.store.tables import Id, metadata

transports = Table(
    "transports",
    metadata,
    Column("id", Id, primary_key=True),
    Column("status", String(16), nullable=False),
    Column("source", Id, nullable=False),
    Column("destination", Id, nullable=False),
    Column("item", Id, nullable=False),
    Column("thing", String(200), nullable=False, server_default=""),
    Column("quantity", Integer, nullable=False),
    Column("priority", String(8), nullable=False),
    Column("vehicle", Id, nullable=False, server_default=""),
    Column("vehicle_until_s", Double),
    Column("ability", Id, nullable=False, server_default=""),
    Column("called_by", String(200), nullable=False),
    Column("caller", String(200), nullable=False),
    Column("created_at_s", Double, nullable=False),
    Column("due_at_s", Double, nullable=False),
    Column("not_before_s", Double),
    Column("cancel_at_s", Double),
    Column("ended_at_s", Double),
    Column("updated_at_s", Double, nullable=False),
    Column("task", Id, nullable=False, server_default=""),
    Column("carrier", Id, nullable=False, server_default=""),
    Column("expected_at_s", Double),
    Column("wait", String(16), nullable=False, server_default=""),
    Column("refused", String(16), nullable=False, server_default=""),
    Column("incarnation", Integer, nullable=False, server_default="0"),
    Column("number", Integer, nullable=False, server_default="0"),
    Column("key", String(64)),
    Column("fingerprint", String(64), nullable=False, server_default=""),
    Column("answer", Text, nullable=False, server_default=""),
    CheckConstraint("status IN ('waiting', 'assigned', 'on_board', 'delivered', 'cancelled')", name="status"),
    CheckConstraint("quantity >= 1", name="quantity"),
    UniqueConstraint("key"),
    Index(None, "created_at_s", "id"),
    Index(None, "status", "created_at_s", "id"),
    Index(None, "due_at_s", "id"),
    Index(None, "ended_at_s"),
    comment="Plain transports. incarnation, number: the newest event of its destination that was told about it.",
)


transport_links = Table(
    "transport_links",
    metadata,
    Column("token_hash", String(64), primary_key=True),
    Column("transport_id", Id, ForeignKey("transports.id", ondelete="CASCADE"), nullable=False),
    Column("created_at_s", Double, nullable=False),
    Column("expires_at_s", Double),
    Column("revoked_at_s", Double),
    Index(None, "transport_id"),
    comment="Who has the token may see the transport's page; token_hash is its SHA-256.",
)

HELD = "not_before"
"""The wait of a transport before its time: no gateway has asked its destination yet."""


class TransportRow(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """A plain transport. Times are wall clock seconds."""

    id: str
    status: TransportState = TransportState.WAITING
    source: str
    destination: str
    item: str
    thing: str = ""
    """People's name of a thing without master data (`dray.messages.THING`); empty for a material."""
    quantity: int
    priority: str
    vehicle: str = ""
    vehicle_until_s: float | None = None
    """The time until which only that vehicle is asked; None for always."""
    ability: str = ""
    """An ability that its vehicle needs beside those for the load; empty for none."""
    called_by: str
    """The caller's name, for people."""
    caller: str
    """The caller's kind and id."""
    created_at_s: float
    due_at_s: float
    not_before_s: float | None = None
    """The earliest time of asking the factory; None for at once."""
    cancel_at_s: float | None = None
    """The time of its cancellation; it ends when the factory has confirmed."""
    ended_at_s: float | None = None
    updated_at_s: float
    task: str = ""
    """The name of its present task; empty for none."""
    carrier: str = ""
    expected_at_s: float | None = None
    """The promised arrival of its carrier."""
    wait: str = ""
    """Why it has no carrier: `HELD`, or its destination's reason (`TransportWait`); empty with a carrier."""
    refused: str = ""
    """The reason of its failure (`TransportRefusal`), where that has ended it."""
    incarnation: int = 0
    number: int = 0
    key: str | None = None
    """A digest of the Idempotency-Key and its caller."""
    fingerprint: str = ""
    """A digest of the request."""
    answer: str = ""
    """The answer, for a repeated request."""

    @property
    def has_ended(self) -> bool:
        """Whether its state is final."""
        return self.status in TRANSPORT_ENDED

    @property
    def is_held(self) -> bool:
        """Whether it waits for its time, unknown to its destination."""
        return self.wait == HELD and not self.has_ended


class TransportFilter(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """A filter for transports; empty fields match all."""

    statuses: Sequence[TransportState] = ()
    places: Sequence[str] | None = None
    """Only those from or to one of these; None for all."""
    caller: str = ""
    """Only those of this caller."""
    words: tuple[Sought, ...] = ()
    """Words that must all occur in its id, places, item, vehicle, or caller."""

    def conditions(self) -> list[ColumnElement[bool]]:
        """The conditions for a row."""
        c = transports.c
        wanted: list[ColumnElement[bool]] = []
        if self.statuses:
            wanted.append(c.status.in_([status.value for status in self.statuses]))
        if self.places is not None:
            wanted.append(c.source.in_(self.places) | c.destination.in_(self.places))
        if self.caller:
            wanted.append(c.caller == self.caller)
        return [*wanted, *(_holds(word) for word in self.words)]


SortedBy = Literal["called", "due"]

_KEYS = {"called": transports.c.created_at_s, "due": transports.c.due_at_s}


def place_of(row: TransportRow, by: SortedBy) -> tuple[float, str]:
    """A transport's place in a list."""
    return (row.created_at_s if by == "called" else row.due_at_s), row.id


_OPEN = [state.value for state in TransportState if state not in TRANSPORT_ENDED]


def open_with(items: Collection[str]) -> Select[str, str]:
    """A query for the transports of these items that have not ended: their item as `product`, their id as `of`."""
    c = transports.c
    query = select(c.item.label("product"), c.id.label("of"))
    return query.where(c.status.in_(_OPEN), c.item.in_(sorted(items)))


_COLUMNS = [transports.c[name] for name in TransportRow.__struct_fields__]


class Transports:
    """The plain transports, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, row: TransportRow) -> bool:
        """Store a new one; False when another process has just used its key: then the transaction is over."""
        try:
            await self._connection.execute(insert(transports), [_values(row)])
        except IntegrityError:
            return False
        return True

    async def of_key(self, key: str) -> TransportRow | None:
        """The transport requested under a key, or None."""
        rows = await self._connection.execute(select(*_COLUMNS).where(transports.c.key == key))
        return next((_row(row) for row in rows), None)

    async def get(self, transport: str) -> TransportRow | None:
        """A transport, or None."""
        found = await self.many([transport])
        return found[0] if found else None

    async def many(self, ids: Iterable[str]) -> list[TransportRow]:
        """The transports with these names, if they exist."""
        query = select(*_COLUMNS).where(transports.c.id.in_(list(ids)))
        return [_row(row) for row in await self._connection.execute(query)]

    async def open(self) -> list[TransportRow]:
        """The transports that have not ended, the oldest first."""
        query = select(*_COLUMNS).where(transports.c.status.in_(_OPEN)).order_by(transports.c.created_at_s)
        return [_row(row) for row in await self._connection.execute(query)]

    async def open_count(self) -> int:
        """The number of transports that have not ended."""
        query = select(func.count()).select_from(transports).where(transports.c.status.in_(_OPEN))
        return (await self._connection.execute(query)).scalar_one()

    async def open_ends_of(self, caller: str) -> list[tuple[str, str]]:
        """Source and destination of each open transport of a caller."""
        c = transports.c
        query = select(c.source, c.destination).where(c.status.in_(_OPEN), c.caller == caller)
        return [(source, destination) for source, destination in await self._connection.execute(query)]

    async def page(
        self,
        wanted: TransportFilter,
        after: tuple[float, str] | None,
        limit: int,
        by: SortedBy = "called",
        *,
        descending: bool = True,
    ) -> list[TransportRow]:
        """A part of a list, newest first by default.

        Args:
            wanted: the filter.
            after: the end of the previous page (`place_of`).
            limit: maximum number of transports.
            by: the sort key; equal transports are sorted by id.
            descending: the direction.
        """
        key, name = _KEYS[by], transports.c.id
        query = select(*_COLUMNS).where(*wanted.conditions()).limit(limit)
        query = query.order_by(key.desc(), name.desc()) if descending else query.order_by(key, name)
        if after is not None:
            here, there = tuple_(key, name), tuple_(*after)
            query = query.where(here < there if descending else here > there)
        return [_row(row) for row in await self._connection.execute(query)]

    async def total(self, wanted: TransportFilter) -> int | None:
        """The number of matching transports; None for very many."""
        return await total_of(self._connection, select(transports.c.id).where(*wanted.conditions()))

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some that ended before then; returns the number."""
        old = select(transports.c.id).where(transports.c.ended_at_s < before_s).limit(at_most)
        return (await self._connection.execute(delete(transports).where(transports.c.id.in_(old)))).rowcount

    async def put(self, row: TransportRow) -> None:
        """Replace the state of one."""
        values = _values(row)
        await self._connection.execute(
            update(transports).where(transports.c.id == values.pop("id")).values(**values)
        )

    async def give_back_open(self, at_s: float) -> None:
        """Take all open ones from their carriers: their destinations know them no more and are asked again.

        Args:
            at_s: now (wall clock).
        """
        c = transports.c
        await self._connection.execute(
            update(transports)
            .where(c.status.in_(_OPEN), c.wait != HELD)
            .values(
                status=TransportState.WAITING.value,
                task="",
                carrier="",
                expected_at_s=None,
                wait="",
                updated_at_s=at_s,
            )
        )

    async def follow(self, events: Iterable[Event], to_wall_s: ToWall) -> None:
        """Update the transports by their destinations' events."""
        told = [event for event in events if isinstance(event.fact, TransportProgressed)]
        if not told:
            return
        ids = {event.fact.transport for event in told if isinstance(event.fact, TransportProgressed)}
        before = {row.id: row for row in await self.many(ids)}
        after = dict(before)
        for event in told:
            assert isinstance(event.fact, TransportProgressed)  # noqa: S101 - chosen above
            row = after.get(event.fact.transport)
            if row is not None and event.agent == row.destination:
                after[row.id] = progressed(row, event, event.fact, to_wall_s)
        for name, row in after.items():
            if row != before[name]:
                await self.put(row)


def progressed(row: TransportRow, event: Event, fact: TransportProgressed, to_wall_s: ToWall) -> TransportRow:
    """A transport after its destination's event; an outdated event changes nothing.

    An event with a lower number is outdated, unless it was told so much later that no late one can be: then a thief of the
    destination's certificate has told the number of the far future.
    """
    at_s = to_wall_s(event.at_s)
    is_new = (event.incarnation, event.number) > (row.incarnation, row.number)
    if row.has_ended or not (is_new or at_s > row.updated_at_s + OVERTAKES_S):
        return row
    return msgspec.structs.replace(
        row,
        status=fact.state,
        task=fact.task,
        carrier=fact.carrier,
        expected_at_s=None if fact.expected_s is None else to_wall_s(fact.expected_s),
        wait=fact.wait or "",
        refused=fact.refused or "",
        ended_at_s=at_s if fact.state in TRANSPORT_ENDED else None,
        updated_at_s=max(row.updated_at_s, at_s),
        incarnation=event.incarnation,
        number=event.number,
    )


def _values(row: TransportRow) -> dict[str, object]:
    return msgspec.to_builtins(row)  # type: ignore[no-any-return]


def _row(values: Iterable[object]) -> TransportRow:
    return msgspec.convert(dict(zip(TransportRow.__struct_fields__, values, strict=True)), TransportRow)


def _holds(word: Sought) -> ColumnElement[bool]:
    c = transports.c
    texts = (c.id, c.source, c.destination, c.item, c.thing, c.vehicle, c.carrier, c.called_by)
    return or_(*(text.icontains(word.text, autoescape=True) for text in texts), c.item.in_(word.named))
