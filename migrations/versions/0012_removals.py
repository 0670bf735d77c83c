"""Removals: vehicles that people have carried away, or are putting back.

Revision: 0012, after 0011
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "removals",
        sa.Column("atv", sa.String(128), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("life", sa.BigInteger(), nullable=False),
        sa.Column("seq", sa.BigInteger(), nullable=False),
        sa.Column("node", sa.String(128), nullable=False),
        sa.Column("areas", sa.Text(), nullable=False),
        sa.Column("by", sa.String(80), nullable=False),
        sa.Column("person", sa.String(128), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("ended_at_s", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("atv", name=op.f("pk_removals")),
        comment="The newest word about each vehicle that was carried away; node: where it is being put back. areas: of whoever has "
        "said it, in JSON; null for everywhere. ended_at_s: when the vehicle was heard again.",
    )


def downgrade() -> None:
    op.drop_table("removals")
