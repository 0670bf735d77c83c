"""Search texts of audit lines, like those of orders: all texts in one column, in small letters.

Revision: 0041, after 0040
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0041"
down_revision = "0040"
branch_labels = None
depends_on = None

AT_ONCE = 2_000
"""Maximum lines read and written at once: the log may be long."""

LINES = "SELECT position, who, action, target, from_ip, detail FROM audit WHERE position > :last ORDER BY position LIMIT :most"


def upgrade() -> None:
    op.add_column("audit", sa.Column("search", sa.Text, nullable=False, server_default=""))
    connection, last = op.get_bind(), 0
    while rows := connection.execute(sa.text(LINES), {"last": last, "most": AT_ONCE}).all():
        # Not in SQL, whose lower() may support English letters only.
        texts = [{"of": position, "text": "\n".join(line).casefold()} for position, *line in rows]
        connection.execute(sa.text("UPDATE audit SET search = :text WHERE position = :of"), texts)
        last = rows[-1].position


def downgrade() -> None:
    op.drop_column("audit", "search")
