"""Closures of drawn parts of the floor.

Revision: 0017, after 0016
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("closures", sa.Column("outline", sa.String(500), nullable=False, server_default=""))


def downgrade() -> None:
    op.drop_column("closures", "outline")
