"""Drafts of plants, which people draw beside the running one.

Revision: 0014, after 0013
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "plant_drafts",
        sa.Column("id", sa.String(128), primary_key=True),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("data", sa.Text, nullable=False),
        sa.Column("notes", sa.Text, nullable=False),
        sa.Column("plan_type", sa.String(32), nullable=False),
        sa.Column("plan", sa.LargeBinary),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("at_s", sa.Double, nullable=False),
        comment="Plants that people draw beside the running one. data: JSON; plan: the picture that lies under it.",
    )


def downgrade() -> None:
    op.drop_table("plant_drafts")
