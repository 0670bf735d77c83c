"""Removals in SQL: vehicles that people have carried away, their places of return, and the number of the newest statement about each."""

from __future__ import annotations

import msgspec
from sqlalchemy import BigInteger, Column, Double, String, Table, Text, delete, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import Id, metadata

removals = Table(
    "removals",
    metadata,
    Column("atv", Id, primary_key=True),
    Column("number", BigInteger, nullable=False),
    Column("life", BigInteger, nullable=False),
    Column("seq", BigInteger, nullable=False),
    Column("node", Id, nullable=False),
    Column("areas", Text, nullable=False),
    Column("by", String(80), nullable=False),
    Column("person", Id, nullable=False),
    Column("at_s", Double, nullable=False),
    Column("ended_at_s", Double),
    comment="The newest word about each vehicle that was carried away; node: where it is being put back. areas: of whoever has "
    "said it, in JSON; null for everywhere. ended_at_s: when the vehicle was heard again.",
)


FROM_CONSOLE = "console:"
"""The prefix of the person of a statement made outside the gateways: it does not know the vehicle's last heartbeat."""


class RemovalRow(msgspec.Struct, frozen=True, gc=False):
    """The newest statement about one vehicle. `at_s` is of the wall clock."""

    atv: str
    number: int
    """The statement's number, which grows for each vehicle."""
    life: int
    """With `seq`: the last heartbeat received before the statement."""
    seq: int
    node: str
    """The node of its return; empty while it is off the floor."""
    areas: str
    """The areas in which its author may command: a list in JSON, null for everywhere."""
    by: str
    """The author's name."""
    person: str
    """The author's name, as agents are told it."""
    at_s: float

    @property
    def heard(self) -> tuple[int, int]:
        """The last heartbeat before the statement."""
        return self.life, self.seq

    @property
    def is_bare(self) -> bool:
        """Whether it names no heartbeat, because none was known."""
        return self.person.startswith(FROM_CONSOLE) and self.heard == (0, 0)

    @property
    def granted_in(self) -> tuple[str, ...] | None:
        """The areas; None for everywhere."""
        return msgspec.json.decode(self.areas, type=tuple[str, ...] | None)


COLUMNS = [removals.c[name] for name in RemovalRow.__struct_fields__]


class Removals:
    """The removals, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[RemovalRow]:
        """The removals of vehicles that were not heard since, by id."""
        query = select(*COLUMNS).where(removals.c.ended_at_s.is_(None)).order_by(removals.c.atv)
        return [RemovalRow(*row) for row in await self._connection.execute(query)]

    async def put(self, removal: RemovalRow) -> RemovalRow:
        """Store a statement with the next number; returns it with that."""
        last = select(removals.c.number).where(removals.c.atv == removal.atv)
        before = (await self._connection.execute(last)).scalar() or 0
        numbered = msgspec.structs.replace(removal, number=max(before + 1, int(removal.at_s * 1000)))
        await self._connection.execute(delete(removals).where(removals.c.atv == removal.atv))
        await self._connection.execute(
            insert(removals), [msgspec.structs.asdict(numbered) | {"ended_at_s": None}]
        )
        return numbered

    async def end(self, atv: str, number: int, at_s: float) -> None:
        """The vehicle was heard again after this statement."""
        await self._connection.execute(
            update(removals)
            .where(removals.c.atv == atv, removals.c.number == number, removals.c.ended_at_s.is_(None))
            .values(ended_at_s=at_s)
        )
