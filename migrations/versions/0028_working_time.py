"""Separate counts of machines' rest outside working hours.

Revision: 0028, after 0027
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0028"
down_revision = "0027"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "kpi_samples", sa.Column("machine_resting_s", sa.Double(), server_default="0", nullable=False)
    )


def downgrade() -> None:
    op.drop_column("kpi_samples", "machine_resting_s")
