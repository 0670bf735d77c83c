"""Access: people, their sessions, links and areas, keys of other systems, and the audit log.

Revision: 0003, after 0002
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

POSITION = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    op.create_table(
        "api_keys",
        sa.Column("id", sa.String(length=128), nullable=False),
        sa.Column("name", sa.String(length=80), nullable=False),
        sa.Column("token_hash", sa.String(length=64), nullable=False),
        sa.Column("scopes", sa.Text(), nullable=False),
        sa.Column("created_at_s", sa.Double(), nullable=False),
        sa.Column("expires_at_s", sa.Double(), nullable=True),
        sa.Column("revoked_at_s", sa.Double(), nullable=True),
        sa.Column("used_at_s", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_api_keys")),
        sa.UniqueConstraint("token_hash", name=op.f("uq_api_keys_token_hash")),
        comment="Keys of other systems. scopes: their names, with spaces between them.",
    )
    op.create_table(
        "audit",
        sa.Column("position", POSITION, autoincrement=True, nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("who", sa.String(length=128), nullable=False),
        sa.Column("who_kind", sa.String(length=16), nullable=False),
        sa.Column("from_ip", sa.String(length=64), nullable=False),
        sa.Column("session", sa.String(length=128), nullable=False),
        sa.Column("action", sa.String(length=64), nullable=False),
        sa.Column("target", sa.String(length=128), nullable=False),
        sa.Column("result", sa.String(length=16), nullable=False),
        sa.Column("detail", sa.Text(), nullable=False),
        sa.CheckConstraint("result IN ('done', 'refused', 'failed')", name=op.f("ck_audit_result")),
        sa.PrimaryKeyConstraint("position", name=op.f("pk_audit")),
        comment="Who did what, or tried to; detail is JSON.",
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_audit_action_position"), "audit", ["action", "position"], unique=False)
    op.create_index(op.f("ix_audit_at_s"), "audit", ["at_s"], unique=False)
    op.create_index(op.f("ix_audit_target_position"), "audit", ["target", "position"], unique=False)
    op.create_index(op.f("ix_audit_who_position"), "audit", ["who", "position"], unique=False)
    op.create_table(
        "lockouts",
        sa.Column("subject", sa.String(length=64), nullable=False),
        sa.Column("failures", sa.Integer(), nullable=False),
        sa.Column("failed_at_s", sa.Double(), nullable=False),
        sa.Column("until_s", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("subject", name=op.f("pk_lockouts")),
        comment="Failed logins by the SHA-256 of the name that was given, whether anybody has it or not.",
    )
    op.create_index(op.f("ix_lockouts_failed_at_s"), "lockouts", ["failed_at_s"], unique=False)
    op.create_table(
        "people",
        sa.Column("id", sa.String(length=128), nullable=False),
        sa.Column("name", sa.String(length=80), nullable=False),
        sa.Column("role", sa.String(length=16), nullable=False),
        sa.Column("password_hash", sa.String(length=200), nullable=True),
        sa.Column("pin_hash", sa.String(length=200), nullable=True),
        sa.Column("badge_hash", sa.String(length=64), nullable=True),
        sa.Column("created_at_s", sa.Double(), nullable=False),
        sa.Column("disabled_at_s", sa.Double(), nullable=True),
        sa.CheckConstraint("role IN ('manager', 'operator')", name=op.f("ck_people_role")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_people")),
        sa.UniqueConstraint("badge_hash", name=op.f("uq_people_badge_hash")),
        comment="Who may log in. Nobody is ever deleted: the audit log names people by their ids.",
    )
    op.create_table(
        "secrets",
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("value", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_secrets")),
        comment="Random values that are made once for this database.",
    )
    op.create_table(
        "signing_keys",
        sa.Column("id", sa.String(length=128), nullable=False),
        sa.Column("private_key", sa.Text(), nullable=False),
        sa.Column("public_key", sa.Text(), nullable=False),
        sa.Column("created_at_s", sa.Double(), nullable=False),
        sa.Column("retired_at_s", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_signing_keys")),
        comment="Ed25519 keys, in hexadecimal digits, by which commands to vehicles are signed.",
    )
    op.create_table(
        "login_links",
        sa.Column("token_hash", sa.String(length=64), nullable=False),
        sa.Column("person_id", sa.String(length=128), nullable=False),
        sa.Column("created_at_s", sa.Double(), nullable=False),
        sa.Column("expires_at_s", sa.Double(), nullable=False),
        sa.Column("ended_at_s", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["person_id"], ["people.id"], name=op.f("fk_login_links_person_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("token_hash", name=op.f("pk_login_links")),
        comment="Links by which a person logs in once. ended_at_s: used or taken back.",
    )
    op.create_index(op.f("ix_login_links_person_id"), "login_links", ["person_id"], unique=False)
    op.create_table(
        "people_areas",
        sa.Column("person_id", sa.String(length=128), nullable=False),
        sa.Column("area", sa.String(length=128), nullable=False),
        sa.ForeignKeyConstraint(
            ["person_id"], ["people.id"], name=op.f("fk_people_areas_person_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("person_id", "area", name=op.f("pk_people_areas")),
        comment="The areas in which an operator works.",
    )
    op.create_table(
        "sessions",
        sa.Column("id", sa.String(length=128), nullable=False),
        sa.Column("token_hash", sa.String(length=64), nullable=False),
        sa.Column("person_id", sa.String(length=128), nullable=False),
        sa.Column("station", sa.String(length=128), server_default="", nullable=False),
        sa.Column("created_at_s", sa.Double(), nullable=False),
        sa.Column("used_at_s", sa.Double(), nullable=False),
        sa.Column("expires_at_s", sa.Double(), nullable=False),
        sa.Column("ended_at_s", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["person_id"], ["people.id"], name=op.f("fk_sessions_person_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_sessions")),
        sa.UniqueConstraint("token_hash", name=op.f("uq_sessions_token_hash")),
        comment="Logins. ended_at_s: logged out or taken back; one that only ran out of time has none.",
    )
    op.create_index(op.f("ix_sessions_expires_at_s"), "sessions", ["expires_at_s"], unique=False)
    op.create_index(op.f("ix_sessions_person_id"), "sessions", ["person_id"], unique=False)


def downgrade() -> None:
    op.drop_index(op.f("ix_sessions_person_id"), table_name="sessions")
    op.drop_index(op.f("ix_sessions_expires_at_s"), table_name="sessions")
    op.drop_table("sessions")
    op.drop_table("people_areas")
    op.drop_index(op.f("ix_login_links_person_id"), table_name="login_links")
    op.drop_table("login_links")
    op.drop_table("signing_keys")
    op.drop_table("secrets")
    op.drop_table("people")
    op.drop_index(op.f("ix_lockouts_failed_at_s"), table_name="lockouts")
    op.drop_table("lockouts")
    op.drop_index(op.f("ix_audit_who_position"), table_name="audit")
    op.drop_index(op.f("ix_audit_target_position"), table_name="audit")
    op.drop_index(op.f("ix_audit_at_s"), table_name="audit")
    op.drop_index(op.f("ix_audit_action_position"), table_name="audit")
    op.drop_table("audit")
    op.drop_table("api_keys")
