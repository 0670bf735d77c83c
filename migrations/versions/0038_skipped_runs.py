"""Single moments of recurring work can be left out.

Revision: 0038, after 0037
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0038"
down_revision = "0037"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("schedules", sa.Column("skipped", sa.Text(), server_default="[]", nullable=False))


def downgrade() -> None:
    op.drop_column("schedules", "skipped")
