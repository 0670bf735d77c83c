"""Acknowledgements of alerts.

Revision: 0005, after 0004
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "acknowledgements",
        sa.Column("alert", sa.String(length=192), nullable=False),
        sa.Column("since_at_s", sa.Double(), nullable=False),
        sa.Column("by", sa.String(length=200), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("alert", name=op.f("pk_acknowledgements")),
        comment="Who has taken on which alert; a row leaves when its alert has ended.",
    )


def downgrade() -> None:
    op.drop_table("acknowledgements")
