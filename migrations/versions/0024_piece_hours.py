"""Pieces that machines have made, good and bad ones, by wall hours.

Revision: 0024, after 0023
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0024"
down_revision = "0023"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "piece_hours",
        sa.Column("hour_s", sa.Double(), nullable=False),
        sa.Column("machine", sa.String(128), nullable=False),
        sa.Column("product", sa.String(128), nullable=False),
        sa.Column("good", sa.Integer(), nullable=False),
        sa.Column("bad", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("hour_s", "machine", "product", name=op.f("pk_piece_hours")),
        comment="Pieces that machines have made in a wall hour, good and bad ones.",
    )


def downgrade() -> None:
    op.drop_table("piece_hours")
