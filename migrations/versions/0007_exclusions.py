"""Exclusions of agents.

Revision: 0007, after 0006
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "exclusions",
        sa.Column("agent", sa.String(128), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("reason", sa.String(200), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("readmitted_at_s", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("agent", name=op.f("pk_exclusions")),
        comment="Agents that were ever shut out. number: of the last decision about it, the highest of all is the "
        "list's.",
    )


def downgrade() -> None:
    op.drop_table("exclusions")
