"""The time until which a plain transport waits for one vehicle.

Revision: 0030, after 0029
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0030"
down_revision = "0029"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("transports", sa.Column("vehicle_until_s", sa.Double(), nullable=True))


def downgrade() -> None:
    op.drop_column("transports", "vehicle_until_s")
