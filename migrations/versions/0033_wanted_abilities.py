"""The ability that a plain transport needs beside those for its load.

Revision: 0033, after 0032
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0033"
down_revision = "0032"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("transports", sa.Column("ability", sa.String(128), server_default="", nullable=False))


def downgrade() -> None:
    op.drop_column("transports", "ability")
