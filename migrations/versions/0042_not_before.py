"""The earliest time at which a plain transport is announced.

Revision: 0042, after 0041
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0042"
down_revision = "0041"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("transports", sa.Column("not_before_s", sa.Double()))


def downgrade() -> None:
    op.drop_column("transports", "not_before_s")
