"""A numbered log of all changes of orders and plain transports, so that other systems follow them without a gap.

Triggers write it, in the transaction of each change. There is one writer at a time, so numbers have the order of the
commits.

Revision: 0039, after 0038
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0039"
down_revision = "0038"
branch_labels = None
depends_on = None

KINDS = {"orders": "order", "transports": "transport"}

FUNCTION = """
CREATE FUNCTION log_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO change_log (kind, subject, status, at_s) VALUES (TG_ARGV[0], NEW.id, NEW.status, NEW.updated_at_s);
    RETURN NULL;
END $$
"""

EVENTS = {"new": "INSERT", "changed": "UPDATE OF status, updated_at_s"}


def upgrade() -> None:
    op.create_table(
        "change_log",
        sa.Column(
            "position",
            sa.BigInteger().with_variant(sa.Integer, "sqlite"),
            primary_key=True,
            autoincrement=True,
        ),
        sa.Column("kind", sa.String(16), nullable=False),
        sa.Column("subject", sa.String(128), nullable=False),
        sa.Column("status", sa.String(16), nullable=False),
        sa.Column("at_s", sa.Double, nullable=False),
        sqlite_autoincrement=True,
        comment="Every change of an order or a plain transport, in the order of the commits. Written by triggers.",
    )
    op.create_index("ix_change_log_at_s", "change_log", ["at_s"])
    # The beginning of the log: earlier changes are unknown.
    op.execute("INSERT INTO change_log (kind, subject, status, at_s) VALUES ('begin', '', '', 0)")
    is_postgresql = op.get_bind().dialect.name == "postgresql"
    if is_postgresql:
        op.execute(FUNCTION)
    for table, kind in KINDS.items():
        for name, event in EVENTS.items():
            begin = f"CREATE TRIGGER log_{name}_{table} AFTER {event} ON {table} FOR EACH ROW "
            if is_postgresql:
                op.execute(f"{begin} EXECUTE FUNCTION log_change('{kind}')")
            else:
                op.execute(
                    f"{begin} BEGIN INSERT INTO change_log (kind, subject, status, at_s) "  # noqa: S608 - of our own names
                    f"VALUES ('{kind}', NEW.id, NEW.status, NEW.updated_at_s); END"
                )


def downgrade() -> None:
    is_postgresql = op.get_bind().dialect.name == "postgresql"
    for table in KINDS:
        for name in EVENTS:
            op.execute(f"DROP TRIGGER log_{name}_{table}" + (f" ON {table}" if is_postgresql else ""))
    if is_postgresql:
        op.execute("DROP FUNCTION log_change")
    op.drop_table("change_log")
