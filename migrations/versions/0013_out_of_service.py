"""Separate counts of the time in which people had taken vehicles out of service.

Revision: 0013, after 0012
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("kpi_samples") as table:
        table.add_column(sa.Column("atv_out_of_service_s", sa.Double(), nullable=False, server_default="0"))


def downgrade() -> None:
    with op.batch_alter_table("kpi_samples") as table:
        table.drop_column("atv_out_of_service_s")
