"""Tables of recordings and spells. See `dray.store.tables` for common rules."""

from __future__ import annotations

from sqlalchemy import Boolean, Column, Double, Index, Integer, LargeBinary, String, Table, Text

from dray.store.tables import Id, Position, metadata

recordings = Table(
    "recordings",
    metadata,
    Column("position", Position, primary_key=True, autoincrement=True),
    Column("recorder", Id, nullable=False),
    Column("from_at_s", Double, nullable=False),
    Column("until_at_s", Double, nullable=False),
    Column("is_whole", Boolean, nullable=False),
    Column("changes", Integer, nullable=False),
    Column("marks", Text, nullable=False),
    Column("frames", LargeBinary, nullable=False),
    Index(None, "from_at_s"),
    sqlite_autoincrement=True,
    comment="What panels showed, piece by piece. frames: compressed lines of JSON; is_whole: the first of them is a snapshot, and not "
    "what is different from the piece before. changes: of tasks and news.",
)

spells = Table(
    "spells",
    metadata,
    Column("position", Position, primary_key=True, autoincrement=True),
    Column("agent", Id, nullable=False),
    Column("doing", String(16), nullable=False),
    Column("from_at_s", Double, nullable=False),
    Column("until_at_s", Double, nullable=False),
    Column("task", Id, nullable=False),
    Column("item", Id, nullable=False),
    Column("source", Id, nullable=False),
    Column("destination", Id, nullable=False),
    Column("other", Id, nullable=False),
    Index(None, "until_at_s"),
    Index(None, "agent", "until_at_s"),
    sqlite_autoincrement=True,
    comment="What vehicles and machines did from when to when. other: for whom or what it waited, or what was wrong.",
)
