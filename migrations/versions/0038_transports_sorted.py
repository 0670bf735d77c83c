"""Indexes of plain transports by due time, and of ended ones by age for their deletion.

Revision: 0038, after 0037
"""

from __future__ import annotations

from alembic import op

revision = "0038"
down_revision = "0037"
branch_labels = None
depends_on = None

COLUMNS = (("due_at_s", "id"), ("ended_at_s",))


def upgrade() -> None:
    for columns in COLUMNS:
        op.create_index(op.f(f"ix_transports_{'_'.join(columns)}"), "transports", list(columns))


def downgrade() -> None:
    for columns in COLUMNS:
        op.drop_index(op.f(f"ix_transports_{'_'.join(columns)}"), "transports")
