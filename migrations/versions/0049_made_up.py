"""When recurring work was made up for after an absence.

Revision: 0049, after 0048
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0049"
down_revision = "0048"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("schedules", sa.Column("made_up_at_s", sa.Double(), nullable=True))


def downgrade() -> None:
    op.drop_column("schedules", "made_up_at_s")
