"""Samples of the factory's figures by wall minutes.

Revision: 0006, after 0005
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

POSITION = sa.BigInteger().with_variant(sa.Integer(), "sqlite")

DOINGS = (
    *("atv_moving", "atv_waiting", "atv_charging", "atv_blocked", "atv_idle", "atv_silent"),
    *("machine_making", "machine_starved", "machine_idle"),
    *("machine_broken", "machine_down", "machine_silent"),
)


def upgrade() -> None:
    op.create_table(
        "kpi_samples",
        sa.Column("position", POSITION, autoincrement=True, nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("span_s", sa.Double(), nullable=False),
        sa.Column("orders_delivered", sa.Integer(), nullable=False),
        sa.Column("orders_on_time", sa.Integer(), nullable=False),
        sa.Column("transports", sa.Integer(), nullable=False),
        sa.Column("transport_p50_s", sa.Double(), nullable=True),
        sa.Column("transport_p95_s", sa.Double(), nullable=True),
        sa.Column("empty_m", sa.Double(), nullable=False),
        sa.Column("loaded_m", sa.Double(), nullable=False),
        sa.Column("commands", sa.Integer(), nullable=False),
        sa.Column("helps", sa.Integer(), nullable=False),
        *(sa.Column(f"{doing}_s", sa.Double(), nullable=False) for doing in DOINGS),
        sa.PrimaryKeyConstraint("position", name=op.f("pk_kpi_samples")),
        comment="What every wall minute has added to the factory's figures; times are factory seconds.",
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_kpi_samples_at_s"), "kpi_samples", ["at_s"], unique=False)


def downgrade() -> None:
    op.drop_index(op.f("ix_kpi_samples_at_s"), table_name="kpi_samples")
    op.drop_table("kpi_samples")
