"""Alerts are stored, with people's comments and the end of an acknowledgement.

Revision: 0023, after 0022
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0023"
down_revision = "0022"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "alerts",
        sa.Column("number", sa.Integer, autoincrement=True, nullable=False),
        sa.Column("alert", sa.String(192), nullable=False),
        sa.Column("kind", sa.String(32), nullable=False),
        sa.Column("level", sa.String(16), nullable=False),
        sa.Column("order_id", sa.String(128), nullable=False),
        sa.Column("since_at_s", sa.Double(), nullable=False),
        sa.Column("ended_at_s", sa.Double()),
        sa.Column("by", sa.String(200), nullable=False, server_default=""),
        sa.Column("at_s", sa.Double(), nullable=False, server_default="0"),
        sa.Column("until_at_s", sa.Double()),
        sa.Column("weight", sa.Double(), nullable=False, server_default="0"),
        sa.Column("came_back", sa.String(16), nullable=False, server_default=""),
        sa.Column("comment", sa.String(500), nullable=False, server_default=""),
        sa.Column("comment_by", sa.String(200), nullable=False, server_default=""),
        sa.Column("told", sa.Text, nullable=False),
        sa.Column("search", sa.Text, nullable=False),
        sa.CheckConstraint("level IN ('alarm', 'warning')", name=op.f("ck_alerts_level")),
        sa.CheckConstraint("came_back IN ('', 'over', 'worse')", name=op.f("ck_alerts_came_back")),
        sa.PrimaryKeyConstraint("number", name=op.f("pk_alerts")),
        comment="Alerts. at_s: when it was taken on; weight: how bad it was then; told: all that was known of it, in JSON.",
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_alerts_since_at_s_number"), "alerts", ["since_at_s", "number"])
    op.create_index(op.f("ix_alerts_ended_at_s"), "alerts", ["ended_at_s"])
    lasts = sa.text("ended_at_s IS NULL")
    op.create_index(
        "ux_alerts_lasting", "alerts", ["alert"], unique=True, sqlite_where=lasts, postgresql_where=lasts
    )
    op.create_table(
        "alert_words",
        sa.Column("number", sa.Integer, autoincrement=True, nullable=False),
        sa.Column("of", sa.Integer, nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("by", sa.String(200), nullable=False),
        sa.Column("said", sa.String(16), nullable=False),
        sa.Column("comment", sa.String(500), nullable=False),
        sa.Column("until_at_s", sa.Double()),
        sa.ForeignKeyConstraint(
            ["of"], ["alerts.number"], name=op.f("fk_alert_words_of_alerts"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("number", name=op.f("pk_alert_words")),
        comment="What was said of alerts, and by whom; by nobody where an alert came back by itself.",
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_alert_words_of"), "alert_words", ["of"])
    op.execute(
        'INSERT INTO alerts (alert, kind, level, order_id, since_at_s, "by", at_s, told, search) '
        "SELECT alert, '', 'warning', '', since_at_s, \"by\", at_s, '', '' FROM acknowledgements"
    )
    op.drop_table("acknowledgements")


def downgrade() -> None:
    op.create_table(
        "acknowledgements",
        sa.Column("alert", sa.String(length=192), nullable=False),
        sa.Column("since_at_s", sa.Double(), nullable=False),
        sa.Column("by", sa.String(length=200), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("alert", name=op.f("pk_acknowledgements")),
        comment="Who has taken on which alert; a row leaves when its alert has ended.",
    )
    op.execute(
        'INSERT INTO acknowledgements (alert, since_at_s, "by", at_s) '
        'SELECT alert, since_at_s, "by", at_s FROM alerts '
        "WHERE ended_at_s IS NULL AND \"by\" <> '' AND came_back = ''"
    )
    op.drop_table("alert_words")
    op.drop_table("alerts")
