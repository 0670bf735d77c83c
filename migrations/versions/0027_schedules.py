"""Recurring work.

Revision: 0027, after 0026
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0027"
down_revision = "0026"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "schedules",
        sa.Column("id", sa.String(128), nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("calendar", sa.String(120), nullable=False),
        sa.Column("time_zone", sa.String(64), nullable=False),
        sa.Column("holidays", sa.Text(), nullable=False),
        sa.Column("make_up", sa.Boolean(), nullable=False),
        sa.Column("paused", sa.Boolean(), nullable=False),
        sa.Column("transport", sa.Text(), nullable=False),
        sa.Column("revision", sa.Integer(), nullable=False),
        sa.Column("by", sa.String(200), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("next_at_s", sa.Double(), nullable=True),
        sa.Column("last_at_s", sa.Double(), nullable=True),
        sa.Column("last_transport", sa.String(128), server_default="", nullable=False),
        sa.Column("last_refused", sa.Text(), server_default="", nullable=False),
        sa.Column("missed_at_s", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_schedules")),
        sa.UniqueConstraint("name", name=op.f("uq_schedules_name")),
        comment="Recurring work. next_at_s: the first moment of its calendar that is not used yet.",
    )
    op.create_index(op.f("ix_schedules_next_at_s"), "schedules", ["next_at_s"])


def downgrade() -> None:
    op.drop_table("schedules")
