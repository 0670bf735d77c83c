"""Public holidays left out by recurring work.

Revision: 0048, after 0047
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0048"
down_revision = "0047"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("schedules", sa.Column("holidays_of", sa.String(64), server_default="", nullable=False))


def downgrade() -> None:
    op.drop_column("schedules", "holidays_of")
