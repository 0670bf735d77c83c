"""The epoch with which a strategist held the order of a goal, if there are several.

Revision: 0032, after 0031
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0032"
down_revision = "0031"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("goals", sa.Column("held", sa.Integer(), nullable=False, server_default="0"))


def downgrade() -> None:
    op.drop_column("goals", "held")
