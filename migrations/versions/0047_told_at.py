"""When the newest fact about a goal was told: a later one counts, whatever number a thief has told.

Revision: 0047, after 0046
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0047"
down_revision = "0046"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("goals", sa.Column("told_at_s", sa.Double()))


def downgrade() -> None:
    op.drop_column("goals", "told_at_s")
