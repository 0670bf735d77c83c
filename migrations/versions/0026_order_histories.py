"""The events for an order's pages are stored with the order when the event log deletes them.

Events still in the log need no copy: they are copied before the log deletes them.

Revision: 0026, after 0025
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0026"
down_revision = "0025"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "order_histories",
        sa.Column("order_id", sa.String(128), nullable=False),
        sa.Column("position", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("planned_at_s", sa.Double()),
        sa.Column("first_piece_at_s", sa.Double()),
        sa.Column("left_at_s", sa.Double()),
        sa.Column("told", sa.LargeBinary, nullable=False),
        sa.PrimaryKeyConstraint("order_id", name=op.f("pk_order_histories")),
        comment="What is kept with an order. position: of the newest event in it; told: events as compressed JSON.",
    )


def downgrade() -> None:
    op.drop_table("order_histories")
