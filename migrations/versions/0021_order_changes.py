"""Changes of orders: their number, the last accepted one, and the pieces that the last one asks for.

Revision: 0021, after 0020
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None


def upgrade() -> None:
    for name in ("change", "change_taken"):
        op.add_column("orders", sa.Column(name, sa.Integer(), server_default="0", nullable=False))
    op.add_column("order_items", sa.Column("wanted", sa.Integer(), nullable=True))


def downgrade() -> None:
    op.drop_column("order_items", "wanted")
    for name in ("change_taken", "change"):
        op.drop_column("orders", name)
