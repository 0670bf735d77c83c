"""Beginnings: when a plant's agents began without a memory, all at once, while the history was kept.

That is every start of a simulated factory, in one process or as a fleet: its floor is new. What earlier lives had left open ended then. Agents
that start again beside others continue from their journals, so no start of theirs is one, and no gateway's.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
from sqlalchemy import Column, Double, Integer, Table, delete, insert, select
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import metadata

KEPT = 1_000
"""Maximum beginnings kept, the newest ones: years of daily starts."""

beginnings = Table(
    "beginnings",
    metadata,
    Column("incarnation", Integer, primary_key=True, autoincrement=False),
    Column("at_s", Double, nullable=False),
    comment="When the agents of a plant began without a memory: all lives with lower numbers had ended.",
)


class Beginning(msgspec.Struct, frozen=True, gc=False):
    """A start of all agents without a memory."""

    incarnation: int
    """The number of their lives then; all earlier lives have lower ones."""
    at_s: float
    """Wall clock."""

    def ended(self, incarnation: int, opened_at_s: float) -> bool:
        """Whether it ended what an agent with this life had opened at this time (wall clock)."""
        return incarnation < self.incarnation and opened_at_s <= self.at_s


class Beginnings:
    """The beginnings, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, beginning: Beginning) -> None:
        """Store a new one."""
        await self._connection.execute(insert(beginnings), [msgspec.structs.asdict(beginning)])
        number = beginnings.c.incarnation
        newest = select(number).order_by(number.desc()).limit(KEPT)
        await self._connection.execute(delete(beginnings).where(number.not_in(newest)))

    async def all(self) -> tuple[Beginning, ...]:
        """All of them, oldest first."""
        query = select(beginnings).order_by(beginnings.c.incarnation)
        return tuple(Beginning(*row) for row in await self._connection.execute(query))


def end_of(all_of: Iterable[Beginning], incarnation: int, opened_at_s: float) -> float | None:
    """When a beginning ended what was opened by this life at this time (wall clock); None if none did.

    Args:
        all_of: the beginnings, oldest first.
        incarnation: the life of the agent that opened it.
        opened_at_s: wall clock.
    """
    return next((each.at_s for each in all_of if each.ended(incarnation, opened_at_s)), None)
