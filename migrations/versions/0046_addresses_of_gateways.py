"""Where each gateway was reached when it was started last: commands print links that lead there.

Revision: 0046, after 0045
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0046"
down_revision = "0045"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "addresses",
        sa.Column("gateway", sa.String(128), primary_key=True),
        sa.Column("url", sa.Text(), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        comment="Where each gateway was reached when it was started last. at_s: when that was, on its wall clock.",
    )


def downgrade() -> None:
    op.drop_table("addresses")
