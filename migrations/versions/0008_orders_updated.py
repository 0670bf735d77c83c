"""The time of an order's last change, and indexes for finding orders.

Revision: 0008, after 0007
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("orders", sa.Column("updated_at_s", sa.Double(), server_default="0", nullable=False))
    op.execute(
        "UPDATE orders SET updated_at_s = "
        "coalesce(delivered_at_s, cancelled_at_s, revoked_at_s, released_at_s, created_at_s)"
    )
    op.create_index(op.f("ix_orders_updated_at_s"), "orders", ["updated_at_s"], unique=False)
    op.create_index(op.f("ix_orders_reference"), "orders", ["reference"], unique=False)


def downgrade() -> None:
    op.drop_index(op.f("ix_orders_reference"), table_name="orders")
    op.drop_index(op.f("ix_orders_updated_at_s"), table_name="orders")
    op.drop_column("orders", "updated_at_s")
