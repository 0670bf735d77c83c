"""Orders, goals, events and the other tables of the first Dray.

Revision: 0001, the first
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

POSITION = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    op.create_table(
        "events",
        sa.Column("position", POSITION, autoincrement=True, nullable=False),
        sa.Column("agent", sa.String(length=128), nullable=False),
        sa.Column("incarnation", sa.Integer(), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("plant_s", sa.Double(), nullable=False),
        sa.Column("kind", sa.String(length=32), nullable=False),
        sa.Column("task", sa.String(length=128), nullable=True),
        sa.Column("goal", sa.String(length=128), nullable=True),
        sa.Column("order_id", sa.String(length=128), nullable=True),
        sa.Column("fact", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("position", name=op.f("pk_events")),
        sa.UniqueConstraint(
            "agent", "incarnation", "number", name=op.f("uq_events_agent_incarnation_number")
        ),
        comment="Agents' numbered histories; fact is the JSON of what happened.",
        sqlite_autoincrement=True,
    )
    op.create_index(op.f("ix_events_agent_position"), "events", ["agent", "position"], unique=False)
    op.create_index(op.f("ix_events_goal"), "events", ["goal"], unique=False)
    op.create_index(op.f("ix_events_kind_position"), "events", ["kind", "position"], unique=False)
    op.create_index(op.f("ix_events_order_id"), "events", ["order_id"], unique=False)
    op.create_index(op.f("ix_events_task"), "events", ["task"], unique=False)
    op.create_table(
        "goals",
        sa.Column("id", sa.String(length=128), nullable=False),
        sa.Column("order_id", sa.String(length=128), nullable=True),
        sa.Column("item", sa.Integer(), nullable=True),
        sa.Column("product", sa.String(length=128), nullable=False),
        sa.Column("quantity", sa.Integer(), server_default="0", nullable=False),
        sa.Column("machine", sa.String(length=128), server_default="", nullable=False),
        sa.Column("promised_at_s", sa.Double(), nullable=True),
        sa.Column("incarnation", sa.Integer(), server_default="0", nullable=False),
        sa.Column("number", sa.Integer(), server_default="0", nullable=False),
        sa.Column("made", sa.Integer(), server_default="0", nullable=False),
        sa.Column("delivered", sa.Integer(), server_default="0", nullable=False),
        sa.Column("delivered_at_s", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_goals")),
        comment="Production goals. incarnation, number: the newest contract that was told about it.",
    )
    op.create_index(op.f("ix_goals_order_id"), "goals", ["order_id"], unique=False)
    op.create_table(
        "heartbeat_samples",
        sa.Column("position", POSITION, autoincrement=True, nullable=False),
        sa.Column("agent", sa.String(length=128), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.Column("plant_s", sa.Double(), nullable=False),
        sa.Column("status", sa.String(length=16), nullable=False),
        sa.Column("battery_frac", sa.Double(), nullable=True),
        sa.Column("x_m", sa.Double(), nullable=True),
        sa.Column("y_m", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("position", name=op.f("pk_heartbeat_samples")),
        comment="Now and then one heartbeat of every agent, for reports.",
        sqlite_autoincrement=True,
    )
    op.create_index(
        op.f("ix_heartbeat_samples_agent_at_s"), "heartbeat_samples", ["agent", "at_s"], unique=False
    )
    op.create_table(
        "incarnations",
        sa.Column("plant", sa.String(length=128), nullable=False),
        sa.Column("incarnation", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("plant", name=op.f("pk_incarnations")),
        comment="How often the agents of a plant have been started.",
    )
    op.create_table(
        "orders",
        sa.Column("id", sa.String(length=128), nullable=False),
        sa.Column("status", sa.String(length=16), nullable=False),
        sa.Column("customer", sa.String(length=200), nullable=False),
        sa.Column("reference", sa.String(length=200), nullable=True),
        sa.Column("token", sa.String(length=64), nullable=False),
        sa.Column("created_at_s", sa.Double(), nullable=False),
        sa.Column("due_at_s", sa.Double(), nullable=True),
        sa.Column("released_at_s", sa.Double(), nullable=True),
        sa.Column("cancelled_at_s", sa.Double(), nullable=True),
        sa.Column("delivered_at_s", sa.Double(), nullable=True),
        sa.Column("incarnation", sa.Integer(), server_default="0", nullable=False),
        sa.CheckConstraint(
            "status IN ('stored', 'released', 'in_production', 'in_delivery', 'delivered', 'cancelled')",
            name=op.f("ck_orders_status"),
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_orders")),
        sa.UniqueConstraint("token", name=op.f("uq_orders_token")),
        comment="Sales orders. incarnation: the newest life of the strategist that accepted the order.",
    )
    op.create_index(op.f("ix_orders_created_at_s_id"), "orders", ["created_at_s", "id"], unique=False)
    op.create_index(
        op.f("ix_orders_status_created_at_s_id"), "orders", ["status", "created_at_s", "id"], unique=False
    )
    op.create_table(
        "products",
        sa.Column("id", sa.String(length=128), nullable=False),
        sa.Column("name", sa.String(length=80), nullable=False),
        sa.Column("made_here", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_products")),
        comment="What could ever be ordered; a product that left the plant stays, for its orders' sake.",
    )
    op.create_table(
        "idempotency_keys",
        sa.Column("key", sa.String(length=255), nullable=False),
        sa.Column("fingerprint", sa.String(length=64), nullable=False),
        sa.Column("order_id", sa.String(length=128), nullable=False),
        sa.Column("answer", sa.Text(), nullable=False),
        sa.Column("at_s", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["order_id"], ["orders.id"], name=op.f("fk_idempotency_keys_order_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("key", name=op.f("pk_idempotency_keys")),
        comment="What was answered to a request with an Idempotency-Key.",
    )
    op.create_index(op.f("ix_idempotency_keys_at_s"), "idempotency_keys", ["at_s"], unique=False)
    op.create_table(
        "order_items",
        sa.Column("order_id", sa.String(length=128), nullable=False),
        sa.Column("item", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("product", sa.String(length=128), nullable=False),
        sa.Column("quantity", sa.Integer(), nullable=False),
        sa.Column("made", sa.Integer(), server_default="0", nullable=False),
        sa.Column("delivered", sa.Integer(), server_default="0", nullable=False),
        sa.CheckConstraint("quantity >= 1", name=op.f("ck_order_items_quantity")),
        sa.ForeignKeyConstraint(
            ["order_id"], ["orders.id"], name=op.f("fk_order_items_order_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(["product"], ["products.id"], name=op.f("fk_order_items_product")),
        sa.PrimaryKeyConstraint("order_id", "item", name=op.f("pk_order_items")),
        comment="Lines of an order; item is the place in the order, from 0.",
    )


def downgrade() -> None:
    op.drop_table("order_items")
    op.drop_index(op.f("ix_idempotency_keys_at_s"), table_name="idempotency_keys")
    op.drop_table("idempotency_keys")
    op.drop_table("products")
    op.drop_index(op.f("ix_orders_status_created_at_s_id"), table_name="orders")
    op.drop_index(op.f("ix_orders_created_at_s_id"), table_name="orders")
    op.drop_table("orders")
    op.drop_table("incarnations")
    op.drop_index(op.f("ix_heartbeat_samples_agent_at_s"), table_name="heartbeat_samples")
    op.drop_table("heartbeat_samples")
    op.drop_index(op.f("ix_goals_order_id"), table_name="goals")
    op.drop_table("goals")
    op.drop_index(op.f("ix_events_task"), table_name="events")
    op.drop_index(op.f("ix_events_order_id"), table_name="events")
    op.drop_index(op.f("ix_events_kind_position"), table_name="events")
    op.drop_index(op.f("ix_events_goal"), table_name="events")
    op.drop_index(op.f("ix_events_agent_position"), table_name="events")
    op.drop_table("events")
