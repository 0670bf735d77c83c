"""Customers' links that can be revoked and can expire.

Every existing order gets a row for the link that came with it.

Revision: 0002, after 0001
"""

from __future__ import annotations

import hashlib

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

ROWS_AT_ONCE = 1000
"""Maximum orders read at once: an old factory may have very many."""


def upgrade() -> None:
    op.create_table(
        "tracking_links",
        sa.Column("token_hash", sa.String(length=64), nullable=False),
        sa.Column("order_id", sa.String(length=128), nullable=False),
        sa.Column("created_at_s", sa.Double(), nullable=False),
        sa.Column("expires_at_s", sa.Double(), nullable=True),
        sa.Column("revoked_at_s", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["order_id"], ["orders.id"], name=op.f("fk_tracking_links_order_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("token_hash", name=op.f("pk_tracking_links")),
        comment="Who has the token may see the order's page; token_hash is its SHA-256.",
    )
    op.create_index(op.f("ix_tracking_links_order_id"), "tracking_links", ["order_id"], unique=False)
    op.create_index(op.f("ix_goals_delivered_at_s"), "goals", ["delivered_at_s"], unique=False)
    _link_what_there_is()


def _link_what_there_is() -> None:
    connection = op.get_bind()
    orders = sa.table("orders", sa.column("id"), sa.column("token"), sa.column("created_at_s"))
    links = sa.table(
        "tracking_links", sa.column("token_hash"), sa.column("order_id"), sa.column("created_at_s")
    )
    last = ""
    while True:
        page = sa.select(orders).where(orders.c.id > last).order_by(orders.c.id).limit(ROWS_AT_ONCE)
        rows = connection.execute(page).all()
        if not rows:
            return
        connection.execute(
            sa.insert(links),
            [
                {
                    "token_hash": hashlib.sha256(row.token.encode()).hexdigest(),
                    "order_id": row.id,
                    "created_at_s": row.created_at_s,
                }
                for row in rows
            ],
        )
        last = rows[-1].id


def downgrade() -> None:
    op.drop_index(op.f("ix_goals_delivered_at_s"), table_name="goals")
    op.drop_index(op.f("ix_tracking_links_order_id"), table_name="tracking_links")
    op.drop_table("tracking_links")
