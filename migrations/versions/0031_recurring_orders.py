"""Recurring orders.

Revision: 0031, after 0030
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0031"
down_revision = "0030"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("schedules", sa.Column("order_draft", sa.Text(), server_default="", nullable=False))
    op.add_column("schedules", sa.Column("last_order", sa.String(128), server_default="", nullable=False))


def downgrade() -> None:
    # An older Dray knows transports only.
    op.execute("DELETE FROM schedules WHERE transport = ''")
    op.drop_column("schedules", "last_order")
    op.drop_column("schedules", "order_draft")
