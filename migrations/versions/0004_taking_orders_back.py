"""The number of an order's releases, and the time of its revocation.

Revision: 0004, after 0003
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("orders", sa.Column("releases", sa.Integer(), server_default="0", nullable=False))
    op.add_column("orders", sa.Column("revoked_at_s", sa.Double(), nullable=True))
    op.execute(
        "UPDATE orders SET releases = 1 WHERE released_at_s IS NOT NULL OR status NOT IN ('stored', 'cancelled')"
    )


def downgrade() -> None:
    op.drop_column("orders", "revoked_at_s")
    op.drop_column("orders", "releases")
