"""Drafts of plants in SQL. A version detects concurrent changes of one draft by two people."""

from __future__ import annotations

import msgspec
from sqlalchemy import (
    Column,
    Double,
    Integer,
    LargeBinary,
    String,
    Table,
    Text,
    delete,
    func,
    insert,
    select,
    update,
)
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import Id, metadata

plant_drafts = Table(
    "plant_drafts",
    metadata,
    Column("id", Id, primary_key=True),
    Column("name", String(80), nullable=False),
    Column("version", Integer, nullable=False),
    Column("data", Text, nullable=False),
    Column("notes", Text, nullable=False),
    Column("plan_type", String(32), nullable=False),
    Column("plan", LargeBinary),
    Column("by", String(80), nullable=False),
    Column("at_s", Double, nullable=False),
    Column("owner", String(200), nullable=False, server_default=""),
    comment="Plants that people draw beside the running one. data: JSON; plan: the picture that lies under it.",
)


class DraftLine(msgspec.Struct, frozen=True, gc=False):
    """A draft in the list."""

    id: str
    name: str
    version: int
    """The content's version: one higher with every change."""
    by: str
    """The author of the last change."""
    at_s: float
    """The time of the last change; wall clock."""


class DraftRow(DraftLine, frozen=True, gc=False):
    """A whole draft, without its floor plan."""

    data: str
    """The content as JSON."""
    notes: str
    """Remarks from reading its file, as a JSON list: of objects, or of lines in an older row."""
    plan_type: str = ""
    """The media type of its floor plan; empty if it has none."""
    owner: str = ""
    """Kind and id of its creator; empty if unknown."""


_LINE = [plant_drafts.c[name] for name in DraftLine.__struct_fields__]
_ROW = [plant_drafts.c[name] for name in DraftRow.__struct_fields__]


class PlantDrafts:
    """The drafts, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def all(self) -> list[DraftLine]:
        """Every draft by id."""
        query = select(*_LINE).order_by(plant_drafts.c.id)
        return [DraftLine(*row) for row in await self._connection.execute(query)]

    async def count(self) -> int:
        """The number of drafts."""
        return (await self._connection.execute(select(func.count()).select_from(plant_drafts))).scalar_one()

    async def count_of(self, owner: str) -> int:
        """The number of drafts of a creator."""
        query = select(func.count()).select_from(plant_drafts).where(plant_drafts.c.owner == owner)
        return (await self._connection.execute(query)).scalar_one()

    async def state(self, draft: str) -> tuple[int, str] | None:
        """Version of a draft and media type of its floor plan, without its content; None without such a draft."""
        query = select(plant_drafts.c.version, plant_drafts.c.plan_type).where(plant_drafts.c.id == draft)
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else (row[0], row[1])

    async def get(self, draft: str) -> DraftRow | None:
        """A draft, or None."""
        query = select(*_ROW).where(plant_drafts.c.id == draft)
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else DraftRow(*row)

    async def put(self, draft: DraftRow) -> None:
        """Store a new draft."""
        await self._connection.execute(insert(plant_drafts), [msgspec.structs.asdict(draft)])

    async def change(self, draft: DraftRow) -> bool:
        """Replace name and content, if the stored version is the previous one; returns whether it was."""
        done = await self._connection.execute(
            update(plant_drafts)
            .where(plant_drafts.c.id == draft.id, plant_drafts.c.version == draft.version - 1)
            .values(name=draft.name, version=draft.version, data=draft.data, by=draft.by, at_s=draft.at_s)
        )
        return bool(done.rowcount)

    async def remove(self, draft: str) -> bool:
        """Delete a draft; returns whether it existed."""
        done = await self._connection.execute(delete(plant_drafts).where(plant_drafts.c.id == draft))
        return bool(done.rowcount)

    async def plan(self, draft: str) -> tuple[str, bytes] | None:
        """Media type and content of a floor plan, or None."""
        query = select(plant_drafts.c.plan_type, plant_drafts.c.plan).where(plant_drafts.c.id == draft)
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None or row[1] is None else (row[0], row[1])

    async def put_plan(self, draft: str, media_type: str, content: bytes | None) -> bool:
        """Set or remove a draft's floor plan; returns whether the draft exists."""
        done = await self._connection.execute(
            update(plant_drafts)
            .where(plant_drafts.c.id == draft)
            .values(plan_type=media_type if content is not None else "", plan=content)
        )
        return bool(done.rowcount)
