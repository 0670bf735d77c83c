"""Indexes of events by subject and kind, and by kind and plant time.

With single indexes a database without statistics may read all events of a kind, which are most of a history.

Revision: 0009, after 0008
"""

from __future__ import annotations

from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None

SUBJECTS = ("task", "goal", "order_id")


def upgrade() -> None:
    for subject in SUBJECTS:
        op.drop_index(op.f(f"ix_events_{subject}"), table_name="events")
        op.create_index(
            op.f(f"ix_events_{subject}_kind_at_s"), "events", [subject, "kind", "at_s"], unique=False
        )
    op.create_index(op.f("ix_events_kind_plant_s"), "events", ["kind", "plant_s"], unique=False)


def downgrade() -> None:
    op.drop_index(op.f("ix_events_kind_plant_s"), table_name="events")
    for subject in SUBJECTS:
        op.drop_index(op.f(f"ix_events_{subject}_kind_at_s"), table_name="events")
        op.create_index(op.f(f"ix_events_{subject}"), "events", [subject], unique=False)
