"""Orders, recurring work and drafts of plants know which caller has begun them, so that one caller takes a share of what all may have.

Of those from before nobody knows: they count for all callers together only.

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
