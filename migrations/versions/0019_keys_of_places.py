"""Keys for transports to and from one place only.

Revision: 0019, after 0018
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("api_keys", sa.Column("place", sa.String(128), nullable=False, server_default=""))


def downgrade() -> None:
    op.drop_column("api_keys", "place")
