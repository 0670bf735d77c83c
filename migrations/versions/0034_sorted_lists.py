"""Indexes for the pages of lists of orders and tasks, for every sort order.

Revision: 0034, after 0033
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0034"
down_revision = "0033"
branch_labels = None
depends_on = None

ENDED_AT = "coalesce(delivered_at_s, cancelled_at_s, created_at_s)"
WANTED = "coalesce(wanted_at_s, due_at_s, 1000000000000000.0)"

KEYS = {
    ("orders", "work"): (
        f"(CASE WHEN (status IN ('delivered', 'cancelled')) THEN 2000000000000000.0 - {ENDED_AT} ELSE {WANTED} END)"
    ),
    ("orders", "due"): "coalesce(due_at_s, 1000000000000000.0)",
    ("orders", "reference"): "coalesce(reference, '')",
    ("orders", "customer"): "customer",
    ("tasks", "work"): "(opened_at_s + CASE WHEN (closed_at_s IS NULL) THEN 1000000000000000.0 ELSE 0.0 END)",
    ("tasks", "promised"): "coalesce(promised_at_s, 1000000000000000.0)",
    ("tasks", "late"): "coalesce(closed_at_s - promised_at_s, -1000000000000000.0)",
}
"""The sort keys, as in the queries."""


def upgrade() -> None:
    for (table, by), key in KEYS.items():
        op.create_index(op.f(f"ix_{table}_by_{by}"), table, [sa.text(key), "id"])


def downgrade() -> None:
    for table, by in KEYS:
        op.drop_index(op.f(f"ix_{table}_by_{by}"), table)
