"""When a simulated factory began anew.

Revision: 0050, after 0049
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0050"
down_revision = "0049"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "beginnings",
        sa.Column("incarnation", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("incarnation", name=op.f("pk_beginnings")),
        comment="When the agents of a plant began without a memory: all lives with lower numbers had ended.",
    )


def downgrade() -> None:
    op.drop_table("beginnings")
