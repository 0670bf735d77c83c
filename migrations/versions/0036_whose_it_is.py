"""Owners of orders, recurring work and drafts of plants, so that a caller is limited to a share of the common maximum.

For existing rows the owner is unknown: they count only for all callers together.

Revision: 0036, after 0035
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0036"
down_revision = "0035"
branch_labels = None
depends_on = None

COLUMNS = (("orders", "caller"), ("schedules", "owner"), ("plant_drafts", "owner"))


def upgrade() -> None:
    for table, name in COLUMNS:
        op.add_column(table, sa.Column(name, sa.String(200), nullable=False, server_default=""))


def downgrade() -> None:
    for table, name in COLUMNS:
        op.drop_column(table, name)
