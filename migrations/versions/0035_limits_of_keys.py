"""Limits of keys' transports: places, materials, open transports at once, and the highest priority.

Existing keys keep their priority. Those of one place get the default limits. Those of all places may belong to a system that calls for
a whole plant, and get ten times as much.

Revision: 0035, after 0034
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0035"
down_revision = "0034"
branch_labels = None
depends_on = None


def upgrade() -> None:
    for name in ("places", "items"):
        op.add_column("api_keys", sa.Column(name, sa.Text(), nullable=False, server_default=""))
    op.add_column("api_keys", sa.Column("open_max", sa.Integer(), nullable=False, server_default="50"))
    op.add_column("api_keys", sa.Column("open_each_max", sa.Integer(), nullable=False, server_default="20"))
    op.add_column("api_keys", sa.Column("priority", sa.String(8), nullable=False, server_default="normal"))
    op.execute("UPDATE api_keys SET places = place, priority = 'urgent'")
    op.execute("UPDATE api_keys SET open_max = 500, open_each_max = 200 WHERE place = ''")
    op.drop_column("api_keys", "place")


def downgrade() -> None:
    """An older Dray would take a key of several places for one of all places: it keeps its first one."""
    op.add_column("api_keys", sa.Column("place", sa.String(128), nullable=False, server_default=""))
    places = sa.table("api_keys", sa.column("id"), sa.column("places"), sa.column("place"))
    connection = op.get_bind()
    for key, named in connection.execute(
        sa.select(places.c.id, places.c.places).where(places.c.places != "")
    ):
        connection.execute(places.update().where(places.c.id == key).values(place=named.split()[0]))
    for name in ("places", "items", "open_max", "open_each_max", "priority"):
        op.drop_column("api_keys", name)
