"""Targets of a shift's figures, the energy use of vehicles, and an index of orders by delivery.

Revision: 0025, after 0024
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0025"
down_revision = "0024"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "report_targets",
        sa.Column("figure", sa.String(32), nullable=False),
        sa.Column("value", sa.Double(), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("figure", name=op.f("pk_report_targets")),
        comment="What figures of a shift should reach; a figure without a row has no target.",
    )
    op.add_column("kpi_samples", sa.Column("energy_wh", sa.Double(), server_default="0", nullable=False))
    op.create_index(op.f("ix_orders_delivered_at_s"), "orders", ["delivered_at_s"])


def downgrade() -> None:
    op.drop_index(op.f("ix_orders_delivered_at_s"), table_name="orders")
    op.drop_column("kpi_samples", "energy_wh")
    op.drop_table("report_targets")
