"""Removals in SQL: which vehicles people have carried away, where they are being put back, and the number of the newest word about each."""

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
"""Begins the person of a word that was said beside the gateways: which heartbeat was heard last is not known to it."""


class RemovalRow(msgspec.Struct, frozen=True, gc=False):
    """The newest word about one vehicle. `at_s` is of the wall clock."""

    atv: str
    number: int
    """Grows with every word about this vehicle."""
    life: int
    """With `seq`: the last heartbeat that was heard before the word."""
    seq: int
    node: str
    """Where it is being put back; empty while it is off the floor."""
    areas: str
    """Where whoever has said it may command: a list in JSON, null for everywhere."""
    by: str
    """The name of who has said it."""
    person: str
    """The same, as agents are told."""
    at_s: float

    @property
    def heard(self) -> tuple[int, int]:
        """The heartbeat after which it was said."""
        return self.life, self.seq

    @property
    def is_bare(self) -> bool:
        """Whether it names no heartbeat, for nobody was asked which one was the last."""
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
        """Of vehicles that were not heard since, by id."""
        query = select(*COLUMNS).where(removals.c.ended_at_s.is_(None)).order_by(removals.c.atv)
        return [RemovalRow(*row) for row in await self._connection.execute(query)]

    async def put(self, removal: RemovalRow) -> RemovalRow:
        """Write a word down, whose number is above the one before; returns it with that."""
        last = select(removals.c.number).where(removals.c.atv == removal.atv)
        before = (await self._connection.execute(last)).scalar() or 0
        numbered = msgspec.structs.replace(removal, number=max(before + 1, int(removal.at_s * 1000)))
        await self._connection.execute(delete(removals).where(removals.c.atv == removal.atv))
        await self._connection.execute(
            insert(removals), [msgspec.structs.asdict(numbered) | {"ended_at_s": None}]
        )
        return numbered

    async def end(self, atv: str, number: int, at_s: float) -> None:
        """The vehicle was heard again after this word."""
        await self._connection.execute(
            update(removals)
            .where(removals.c.atv == atv, removals.c.number == number, removals.c.ended_at_s.is_(None))
            .values(ended_at_s=at_s)
        )
