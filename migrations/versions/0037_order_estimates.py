"""The changes of an order's estimate are stored with the order, each with its cause.

Existing orders have none.

Revision: 0037, after 0036
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0037"
down_revision = "0036"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "order_estimates",
        sa.Column("order_id", sa.String(128), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("from_at_s", sa.Double()),
        sa.Column("to_at_s", sa.Double()),
        sa.Column("cause", sa.String(16), nullable=False),
        sa.Column("agent", sa.String(128), nullable=False),
        sa.Column("other", sa.String(128), nullable=False),
        sa.PrimaryKeyConstraint("order_id", "at_s", name=op.f("pk_order_estimates")),
        sa.ForeignKeyConstraint(
            ["order_id"],
            ["orders.id"],
            name=op.f("fk_order_estimates_order_id"),
            ondelete="CASCADE",
        ),
        comment="How the estimates of orders have moved, and why; without from_at_s and to_at_s where nothing could be told.",
    )


def downgrade() -> None:
    op.drop_table("order_estimates")
