"""Takeovers are stored as long as figures, not as long as the event log; those still in the log are copied.

Revision: 0029, after 0028
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0029"
down_revision = "0028"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "takeovers",
        sa.Column("agent", sa.String(128), nullable=False),
        sa.Column("incarnation", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("number", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("fact", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("agent", "incarnation", "number", name=op.f("pk_takeovers")),
        comment="When somebody else has gone on with a transport, by the event that tells of it; fact is JSON.",
    )
    op.create_index(op.f("ix_takeovers_at_s"), "takeovers", ["at_s"])
    op.execute(
        "INSERT INTO takeovers (agent, incarnation, number, at_s, fact) "
        "SELECT agent, incarnation, number, at_s, fact FROM events "
        "WHERE kind = 'CarrierChanged' AND fact NOT LIKE '%\"carrier\":\"\"%'"
    )


def downgrade() -> None:
    op.drop_table("takeovers")
