"""Recordings of the panels' view, and spells of agents.

Revision: 0018, after 0017
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None


def upgrade() -> None:
    position = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    op.create_table(
        "recordings",
        sa.Column("position", position, autoincrement=True, nullable=False),
        sa.Column("recorder", sa.String(128), nullable=False),
        sa.Column("from_at_s", sa.Double(), nullable=False),
        sa.Column("until_at_s", sa.Double(), nullable=False),
        sa.Column("is_whole", sa.Boolean(), nullable=False),
        sa.Column("changes", sa.Integer(), nullable=False),
        sa.Column("marks", sa.Text(), nullable=False),
        sa.Column("frames", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("position", name=op.f("pk_recordings")),
        sqlite_autoincrement=True,
        comment="What panels showed, piece by piece. frames: compressed lines of JSON; is_whole: the first of them is a snapshot, "
        "and not what is different from the piece before. changes: of tasks and news.",
    )
    op.create_index(op.f("ix_recordings_from_at_s"), "recordings", ["from_at_s"])
    op.create_table(
        "spells",
        sa.Column("position", position, autoincrement=True, nullable=False),
        sa.Column("agent", sa.String(128), nullable=False),
        sa.Column("doing", sa.String(16), nullable=False),
        sa.Column("from_at_s", sa.Double(), nullable=False),
        sa.Column("until_at_s", sa.Double(), nullable=False),
        sa.Column("task", sa.String(128), nullable=False),
        sa.Column("item", sa.String(128), nullable=False),
        sa.Column("source", sa.String(128), nullable=False),
        sa.Column("destination", sa.String(128), nullable=False),
        sa.Column("other", sa.String(128), nullable=False),
        sa.PrimaryKeyConstraint("position", name=op.f("pk_spells")),
        sqlite_autoincrement=True,
        comment="What vehicles and machines did from when to when. other: for whom or what it waited, or what was wrong.",
    )
    op.create_index(op.f("ix_spells_until_at_s"), "spells", ["until_at_s"])
    op.create_index(op.f("ix_spells_agent_until_at_s"), "spells", ["agent", "until_at_s"])


def downgrade() -> None:
    op.drop_table("spells")
    op.drop_table("recordings")
