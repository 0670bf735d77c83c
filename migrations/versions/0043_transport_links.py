"""Links to the pages of plain transports.

Revision: 0043, after 0042
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0043"
down_revision = "0042"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "transport_links",
        sa.Column("token_hash", sa.String(64), primary_key=True),
        sa.Column("transport_id", sa.String(128), nullable=False),
        sa.Column("created_at_s", sa.Double, nullable=False),
        sa.Column("expires_at_s", sa.Double),
        sa.Column("revoked_at_s", sa.Double),
        sa.ForeignKeyConstraint(
            ["transport_id"],
            ["transports.id"],
            name="fk_transport_links_transport_id",
            ondelete="CASCADE",
        ),
        comment="Who has the token may see the transport's page; token_hash is its SHA-256.",
    )
    op.create_index("ix_transport_links_transport_id", "transport_links", ["transport_id"])


def downgrade() -> None:
    op.drop_table("transport_links")
