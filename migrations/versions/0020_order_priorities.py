"""Priorities of orders.

Revision: 0020, after 0019
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("orders", sa.Column("priority", sa.String(8), server_default="normal", nullable=False))
    op.add_column("orders", sa.Column("wanted_at_s", sa.Double(), nullable=True))


def downgrade() -> None:
    op.drop_column("orders", "wanted_at_s")
    op.drop_column("orders", "priority")
