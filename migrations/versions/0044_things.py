"""Plain transports of things without master data.

Revision: 0044, after 0043
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0044"
down_revision = "0043"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("transports", sa.Column("thing", sa.String(200), nullable=False, server_default=""))


def downgrade() -> None:
    op.drop_column("transports", "thing")
