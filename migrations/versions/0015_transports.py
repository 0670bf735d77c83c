"""Plain transports of people and programs.

Revision: 0015, after 0014
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None

STATUS = "status IN ('waiting', 'assigned', 'on_board', 'delivered', 'cancelled')"


def upgrade() -> None:
    op.create_table(
        "transports",
        sa.Column("id", sa.String(128), nullable=False),
        sa.Column("status", sa.String(16), nullable=False),
        sa.Column("source", sa.String(128), nullable=False),
        sa.Column("destination", sa.String(128), nullable=False),
        sa.Column("item", sa.String(128), nullable=False),
        sa.Column("quantity", sa.Integer, nullable=False),
        sa.Column("priority", sa.String(8), nullable=False),
        sa.Column("vehicle", sa.String(128), nullable=False, server_default=""),
        sa.Column("called_by", sa.String(200), nullable=False),
        sa.Column("caller", sa.String(200), nullable=False),
        sa.Column("created_at_s", sa.Double, nullable=False),
        sa.Column("due_at_s", sa.Double, nullable=False),
        sa.Column("cancel_at_s", sa.Double),
        sa.Column("ended_at_s", sa.Double),
        sa.Column("updated_at_s", sa.Double, nullable=False),
        sa.Column("task", sa.String(128), nullable=False, server_default=""),
        sa.Column("carrier", sa.String(128), nullable=False, server_default=""),
        sa.Column("expected_at_s", sa.Double),
        sa.Column("wait", sa.String(16), nullable=False, server_default=""),
        sa.Column("refused", sa.String(16), nullable=False, server_default=""),
        sa.Column("incarnation", sa.Integer, nullable=False, server_default="0"),
        sa.Column("number", sa.Integer, nullable=False, server_default="0"),
        sa.Column("key", sa.String(64)),
        sa.Column("fingerprint", sa.String(64), nullable=False, server_default=""),
        sa.Column("answer", sa.Text, nullable=False, server_default=""),
        sa.CheckConstraint(STATUS, name=op.f("ck_transports_status")),
        sa.CheckConstraint("quantity >= 1", name=op.f("ck_transports_quantity")),
        sa.UniqueConstraint("key", name=op.f("uq_transports_key")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_transports")),
        comment="Plain transports. incarnation, number: the newest event of its destination that was told about it.",
    )
    op.create_index(op.f("ix_transports_created_at_s_id"), "transports", ["created_at_s", "id"])
    op.create_index(
        op.f("ix_transports_status_created_at_s_id"), "transports", ["status", "created_at_s", "id"]
    )


def downgrade() -> None:
    op.drop_table("transports")
