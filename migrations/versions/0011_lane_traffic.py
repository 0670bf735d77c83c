"""The traffic of vehicles on each lane, by wall hours.

Revision: 0011, after 0010
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "lane_traffic",
        sa.Column("hour_s", sa.Double(), nullable=False),
        sa.Column("start_node", sa.String(128), nullable=False),
        sa.Column("end_node", sa.String(128), nullable=False),
        sa.Column("passes", sa.Integer(), nullable=False),
        sa.Column("waits", sa.Integer(), nullable=False),
        sa.Column("waited_s", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("hour_s", "start_node", "end_node", name=op.f("pk_lane_traffic")),
        comment="What vehicles did on each lane in a wall hour; waited_s is in factory seconds.",
    )


def downgrade() -> None:
    op.drop_table("lane_traffic")
