"""Search texts of orders; tasks are stored with their results.

Revision: 0022, after 0021
"""

from __future__ import annotations

from collections import defaultdict

import sqlalchemy as sa
from alembic import op

revision = "0022"
down_revision = "0021"
branch_labels = None
depends_on = None

STATE = "state IN ('bidding', 'contracted', 'delivered', 'withdrawn')"


def upgrade() -> None:
    op.add_column("orders", sa.Column("search", sa.Text, nullable=False, server_default=""))
    _write_what_is_searched()
    op.create_table(
        "tasks",
        sa.Column("id", sa.String(128), nullable=False),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("coordinator", sa.String(128), nullable=False),
        sa.Column("item", sa.String(128), nullable=False),
        sa.Column("quantity", sa.Integer, nullable=False),
        sa.Column("source", sa.String(128), nullable=False),
        sa.Column("destination", sa.String(128), nullable=False),
        sa.Column("goal", sa.String(128), nullable=False),
        sa.Column("order_id", sa.String(128), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("carrier", sa.String(128), nullable=False),
        sa.Column("standby", sa.String(128), nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("round", sa.Integer, nullable=False),
        sa.Column("opened_at_s", sa.Double, nullable=False),
        sa.Column("contracted_at_s", sa.Double),
        sa.Column("promised_at_s", sa.Double),
        sa.Column("deadline_at_s", sa.Double, nullable=False),
        sa.Column("closed_at_s", sa.Double),
        sa.Column("incarnation", sa.Integer, nullable=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("search", sa.Text, nullable=False),
        sa.CheckConstraint(STATE, name=op.f("ck_tasks_state")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_tasks")),
        comment="Tasks as their coordinators told of them. incarnation, number: the newest event that was told about it.",
    )
    op.create_index(op.f("ix_tasks_opened_at_s_id"), "tasks", ["opened_at_s", "id"])
    op.create_index(op.f("ix_tasks_state_opened_at_s_id"), "tasks", ["state", "opened_at_s", "id"])
    op.create_index(op.f("ix_tasks_order_id"), "tasks", ["order_id"])


def downgrade() -> None:
    op.drop_table("tasks")
    op.drop_column("orders", "search")


def _write_what_is_searched() -> None:
    """Fill the search texts of existing orders; not in SQL, whose lower() may support English letters only."""
    connection = op.get_bind()
    products = defaultdict(list)
    for order, product in connection.execute(
        sa.text("SELECT order_id, product FROM order_items ORDER BY order_id, item")
    ):
        products[order].append(product)
    rows = connection.execute(sa.text("SELECT id, reference, customer FROM orders")).all()
    texts = [
        {
            "of": order,
            "text": "\n".join(
                (order, reference or "", customer, f"|{'|'.join(products[order])}|")
            ).casefold(),
        }
        for order, reference, customer in rows
    ]
    if texts:
        connection.execute(sa.text("UPDATE orders SET search = :text WHERE id = :of"), texts)
