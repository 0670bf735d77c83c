"""Recordings of the panels' view in SQL, in pieces of some seconds."""

from __future__ import annotations

import msgspec
from sqlalchemy import delete, func, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.replay.tables import recordings

PIECES_READ = 100
"""Maximum pieces of one answer: many times the number between two snapshots."""


LONGEST_S = 3600.0
"""Maximum length of a piece, and so of the search for one that lasts until now."""


class Piece(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """Some seconds of the panels' view. Times are wall clock."""

    recorder: str
    """The gateway and its life."""
    from_at_s: float
    """The time of its first frame."""
    until_at_s: float
    """The end of the time that its last frame describes."""
    is_whole: bool
    """Whether its first line is a snapshot; otherwise it continues the previous piece."""
    changes: int
    """Number of changes of tasks and news."""
    marks: str
    """JSON: marks for searching."""
    frames: bytes
    """Lines of JSON, compressed by zlib."""


class Outline(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """A piece without its frames."""

    recorder: str
    from_at_s: float
    until_at_s: float
    changes: int
    marks: str


class Recordings:
    """The recordings, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, piece: Piece) -> None:
        """Store a piece."""
        await self._connection.execute(insert(recordings), [msgspec.structs.asdict(piece)])

    async def is_kept_by_another(self, recorder: str, since_s: float) -> bool:
        """Whether another gateway has stored recordings after this moment."""
        query = (
            select(recordings.c.position)
            .where(recordings.c.from_at_s >= since_s - LONGEST_S, recordings.c.until_at_s > since_s)
            .where(recordings.c.recorder != recorder)
            .limit(1)
        )
        return (await self._connection.execute(query)).first() is not None

    async def pieces(self, since_s: float, until_s: float) -> list[Piece]:
        """The pieces for a replay from one moment to another: from the snapshot before the first moment, oldest first.

        Empty if nothing is stored at or before the first moment.
        """
        begin = (
            select(recordings.c.from_at_s, recordings.c.position)
            .where(recordings.c.is_whole, recordings.c.from_at_s <= since_s)
            .order_by(recordings.c.from_at_s.desc(), recordings.c.position.desc())
            .limit(1)
        )
        whole = (await self._connection.execute(begin)).first()
        if whole is None:
            return []
        columns = [recordings.c[name] for name in Piece.__struct_fields__]
        query = (
            select(*columns)
            .where(
                recordings.c.from_at_s >= whole.from_at_s,
                recordings.c.from_at_s <= until_s,
                recordings.c.position >= whole.position,
            )
            .order_by(recordings.c.position)
            .limit(PIECES_READ)
        )
        return [Piece(**row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001

    async def outlines(self, since_s: float, until_s: float) -> list[Outline]:
        """The pieces of a time without their frames, oldest first."""
        columns = [recordings.c[name] for name in Outline.__struct_fields__]
        query = (
            select(*columns)
            .where(recordings.c.from_at_s >= since_s, recordings.c.from_at_s <= until_s)
            .order_by(recordings.c.from_at_s)
        )
        return [Outline(**row._mapping) for row in await self._connection.execute(query)]  # noqa: SLF001

    async def span(self) -> tuple[float, float] | None:
        """The times of the first and last stored frame; None for none."""
        first = (await self._connection.execute(select(func.min(recordings.c.from_at_s)))).scalar()
        if first is None:
            return None
        newest = select(recordings.c.until_at_s).order_by(recordings.c.from_at_s.desc()).limit(1)
        return first, (await self._connection.execute(newest)).scalar_one()

    async def bytes_kept(self) -> int:
        """The total size of all frames in bytes."""
        total = select(func.coalesce(func.sum(func.length(recordings.c.frames)), 0))
        return int((await self._connection.execute(total)).scalar_one())

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some of the oldest that began before this moment; returns the number."""
        c = recordings.c
        old = select(c.position).where(c.from_at_s < before_s).order_by(c.from_at_s).limit(at_most)
        return (await self._connection.execute(delete(recordings).where(c.position.in_(old)))).rowcount
