"""Skipped moments of recurring work.

Revision: 0040, after 0039
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0040"
down_revision = "0039"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("schedules", sa.Column("skipped", sa.Text(), server_default="[]", nullable=False))


def downgrade() -> None:
    op.drop_column("schedules", "skipped")
