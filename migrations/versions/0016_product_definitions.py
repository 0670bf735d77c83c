"""Products defined by people.

Revision: 0016, after 0015
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("products", sa.Column("revision", sa.Integer, nullable=False, server_default="1"))
    op.add_column("products", sa.Column("definition", sa.Text, nullable=False, server_default=""))
    op.add_column("products", sa.Column("by", sa.String(200), nullable=False, server_default=""))
    op.add_column("products", sa.Column("at_s", sa.Double, nullable=False, server_default="0"))


def downgrade() -> None:
    for name in ("at_s", "by", "definition", "revision"):
        op.drop_column("products", name)
