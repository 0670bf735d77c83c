"""Tables: the definitions. Queries are in the repositories, in the folders beside this module.

Times are seconds since 1970 on the wall clock, as double precision numbers: SQLite has no type for times, and
PostgreSQL's would read back differently. `plant_s` is a time on the plant's clock. The migrations create the same tables;
a test compares them.
"""

from __future__ import annotations

from functools import partial

from sqlalchemy import (
    BigInteger,
    Boolean,
    CheckConstraint,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
    false,
)

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
    }
)

Position = BigInteger().with_variant(Integer, "sqlite")
"""An ascending row number: SQLite assigns numbers itself only in a plain INTEGER."""

Id = String(128)
"""Ids of agents have 32 characters at most; those of tasks and goals contain up to three ids."""

_counter = partial(Column, type_=Integer, nullable=False, server_default="0")

products = Table(
    "products",
    metadata,
    Column("id", Id, primary_key=True),
    Column("name", String(80), nullable=False),
    Column("made_here", Boolean, nullable=False, server_default=false()),
    Column("revision", Integer, nullable=False, server_default="1"),
    Column("definition", Text, nullable=False, server_default=""),
    Column("by", String(200), nullable=False, server_default=""),
    Column("at_s", Double, nullable=False, server_default="0"),
    comment="What could ever be ordered; a product that left the plant stays, for its orders' sake.",
)

orders = Table(
    "orders",
    metadata,
    Column("id", Id, primary_key=True),
    Column("status", String(16), nullable=False),
    Column("customer", String(200), nullable=False),
    Column("reference", String(200)),
    Column("token", String(64), nullable=False),
    Column("created_at_s", Double, nullable=False),
    Column("due_at_s", Double),
    *(Column(name, Double) for name in ("released_at_s", "cancelled_at_s", "delivered_at_s")),
    *(_counter(name) for name in ("incarnation", "releases", "change", "change_taken")),
    Column("revoked_at_s", Double),
    Column("updated_at_s", Double, nullable=False, server_default="0"),
    Column("priority", String(8), nullable=False, server_default="normal"),
    Column("wanted_at_s", Double),
    Column("search", Text, nullable=False, server_default=""),
    Column("caller", String(200), nullable=False, server_default=""),
    CheckConstraint(
        "status IN ('stored', 'released', 'in_production', 'in_delivery', 'delivered', 'cancelled')",
        name="status",
    ),
    UniqueConstraint("token"),
    Index(None, "created_at_s", "id"),
    Index(None, "status", "created_at_s", "id"),
    Index(None, "updated_at_s"),
    Index(None, "reference"),
    Index(None, "delivered_at_s"),
    comment="Sales orders. incarnation: the newest life of the strategist that accepted the order.",
)

order_items = Table(
    "order_items",
    metadata,
    Column("order_id", Id, ForeignKey("orders.id", ondelete="CASCADE"), primary_key=True),
    Column("item", Integer, primary_key=True, autoincrement=False),
    Column("product", Id, ForeignKey("products.id"), nullable=False),
    Column("quantity", Integer, nullable=False),
    Column("wanted", Integer),
    *(_counter(name) for name in ("made", "delivered")),
    CheckConstraint("quantity >= 1", name="quantity"),
    Index(None, "product"),
    comment="Lines of an order; item is the place in the order, from 0.",
)

tracking_links = Table(
    "tracking_links",
    metadata,
    Column("token_hash", String(64), primary_key=True),
    Column("order_id", Id, ForeignKey("orders.id", ondelete="CASCADE"), nullable=False),
    Column("created_at_s", Double, nullable=False),
    Column("expires_at_s", Double),
    Column("revoked_at_s", Double),
    Index(None, "order_id"),
    comment="Who has the token may see the order's page; token_hash is its SHA-256.",
)

# No foreign key to orders: facts come from the bus, in any order, and may belong to another database.
goals = Table(
    "goals",
    metadata,
    Column("id", Id, primary_key=True),
    Column("order_id", Id),
    Column("item", Integer),
    Column("product", Id, nullable=False),
    Column("quantity", Integer, nullable=False, server_default="0"),
    Column("machine", Id, nullable=False, server_default=""),
    Column("promised_at_s", Double),
    *(_counter(name) for name in ("held", "incarnation", "number", "made", "delivered")),
    Column("told_at_s", Double),
    Column("delivered_at_s", Double),
    Index(None, "order_id"),
    Index(None, "delivered_at_s"),
    comment="Production goals. incarnation, number: the newest contract that was told about it.",
)

events = Table(
    "events",
    metadata,
    Column("position", Position, primary_key=True, autoincrement=True),
    Column("agent", Id, nullable=False),
    Column("incarnation", Integer, nullable=False),
    Column("number", Integer, nullable=False),
    Column("at_s", Double, nullable=False),
    Column("plant_s", Double, nullable=False),
    Column("kind", String(32), nullable=False),
    Column("task", Id),
    Column("goal", Id),
    Column("order_id", Id),
    Column("fact", Text, nullable=False),
    UniqueConstraint("agent", "incarnation", "number"),
    Index(None, "kind", "position"),
    Index(None, "agent", "position"),
    # Queries about one thing mostly ask for one kind: an index on both keeps the database from reading all of a kind.
    Index(None, "task", "kind", "at_s"),
    Index(None, "goal", "kind", "at_s"),
    Index(None, "order_id", "kind", "at_s"),
    Index(None, "kind", "plant_s"),
    # Numbers of deleted rows must never be reused: readers continue after the last one they saw.
    sqlite_autoincrement=True,
    comment="Agents' numbered histories; fact is the JSON of what happened.",
)

heartbeat_samples = Table(
    "heartbeat_samples",
    metadata,
    Column("position", Position, primary_key=True, autoincrement=True),
    Column("agent", Id, nullable=False),
    Column("at_s", Double, nullable=False),
    Column("plant_s", Double, nullable=False),
    Column("status", String(16), nullable=False),
    Column("battery_frac", Double),
    Column("x_m", Double),
    Column("y_m", Double),
    Index(None, "agent", "at_s"),
    sqlite_autoincrement=True,
    comment="Now and then one heartbeat of every agent, for reports.",
)

ATV_DOINGS = ("moving", "waiting", "charging", "blocked", "idle", "silent")
MACHINE_DOINGS = ("making", "starved", "idle", "broken", "down", "silent")

kpi_samples = Table(
    "kpi_samples",
    metadata,
    Column("position", Position, primary_key=True, autoincrement=True),
    Column("at_s", Double, nullable=False),
    Column("span_s", Double, nullable=False),
    Column("orders_delivered", Integer, nullable=False),
    Column("orders_on_time", Integer, nullable=False),
    Column("transports", Integer, nullable=False),
    Column("transport_p50_s", Double),
    Column("transport_p95_s", Double),
    Column("empty_m", Double, nullable=False),
    Column("loaded_m", Double, nullable=False),
    Column("commands", Integer, nullable=False),
    Column("helps", Integer, nullable=False),
    *(Column(f"atv_{doing}_s", Double, nullable=False) for doing in ATV_DOINGS),
    *(Column(f"machine_{doing}_s", Double, nullable=False) for doing in MACHINE_DOINGS),
    Column("atv_out_of_service_s", Double, nullable=False, server_default="0"),
    Column("energy_wh", Double, nullable=False, server_default="0"),
    Column("machine_resting_s", Double, nullable=False, server_default="0"),
    Index(None, "at_s"),
    sqlite_autoincrement=True,
    comment="What every wall minute has added to the factory's figures; times are factory seconds.",
)

piece_hours = Table(
    "piece_hours",
    metadata,
    Column("hour_s", Double, primary_key=True),
    Column("machine", Id, primary_key=True),
    Column("product", Id, primary_key=True),
    *(Column(kind, Integer, nullable=False) for kind in ("good", "bad")),
    comment="Pieces that machines have made in a wall hour, good and bad ones.",
)

idempotency_keys = Table(
    "idempotency_keys",
    metadata,
    Column("key", String(255), primary_key=True),
    Column("fingerprint", String(64), nullable=False),
    Column("order_id", Id, ForeignKey("orders.id", ondelete="CASCADE"), nullable=False),
    Column("answer", Text, nullable=False),
    Column("at_s", Double, nullable=False),
    Index(None, "at_s"),
    comment="What was answered to a request with an Idempotency-Key.",
)

exclusions = Table(
    "exclusions",
    metadata,
    Column("agent", Id, primary_key=True),
    Column("number", BigInteger, nullable=False),
    Column("reason", String(200), nullable=False),
    Column("by", String(80), nullable=False),
    Column("at_s", Double, nullable=False),
    Column("readmitted_at_s", Double),
    comment="Agents that were ever shut out. number: of the last decision about it, the highest of all is the list's.",
)

closures = Table(
    "closures",
    metadata,
    Column("id", Id, primary_key=True),
    Column("number", BigInteger, nullable=False),
    Column("kind", String(16), nullable=False),
    Column("start_node", Id, nullable=False),
    Column("end_node", Id, nullable=False),
    Column("place", Id, nullable=False),
    Column("area", Id, nullable=False),
    Column("outline", String(500), nullable=False, server_default=""),
    Column("speed_mps", Double),
    Column("until_s", Double),
    Column("reason", String(200), nullable=False),
    Column("by", String(80), nullable=False),
    Column("person", Id, nullable=False),
    Column("at_s", Double, nullable=False),
    Column("ended_at_s", Double),
    comment="Lanes, places and areas that were closed. number: of the last decision about it, the highest of all is the list's.",
)

incarnations = Table(
    "incarnations",
    metadata,
    Column("plant", Id, primary_key=True),
    Column("incarnation", Integer, nullable=False),
    comment="How often the agents of a plant have been started.",
)

# --- who is who ----------------------------------------------------------------------------------

TokenHash = String(64)
"""A SHA-256 in hexadecimal digits."""

people = Table(
    "people",
    metadata,
    Column("id", Id, primary_key=True),
    Column("name", String(80), nullable=False),
    Column("role", String(16), nullable=False),
    Column("password_hash", String(200)),
    Column("pin_hash", String(200)),
    Column("badge_hash", TokenHash),
    Column("created_at_s", Double, nullable=False),
    Column("disabled_at_s", Double),
    CheckConstraint("role IN ('manager', 'operator')", name="role"),
    UniqueConstraint("badge_hash"),
    comment="Who may log in. Nobody is ever deleted: the audit log names people by their ids.",
)

people_areas = Table(
    "people_areas",
    metadata,
    Column("person_id", Id, ForeignKey("people.id", ondelete="CASCADE"), primary_key=True),
    Column("area", Id, primary_key=True),
    comment="The areas in which an operator works.",
)

sessions = Table(
    "sessions",
    metadata,
    Column("id", Id, primary_key=True),
    Column("token_hash", TokenHash, nullable=False),
    Column("person_id", Id, ForeignKey("people.id", ondelete="CASCADE"), nullable=False),
    Column("station", Id, nullable=False, server_default=""),
    Column("created_at_s", Double, nullable=False),
    Column("used_at_s", Double, nullable=False),
    Column("expires_at_s", Double, nullable=False),
    Column("ended_at_s", Double),
    UniqueConstraint("token_hash"),
    Index(None, "person_id"),
    Index(None, "expires_at_s"),
    comment="Logins. ended_at_s: logged out or taken back; one that only ran out of time has none.",
)

login_links = Table(
    "login_links",
    metadata,
    Column("token_hash", TokenHash, primary_key=True),
    Column("person_id", Id, ForeignKey("people.id", ondelete="CASCADE"), nullable=False),
    Column("created_at_s", Double, nullable=False),
    Column("expires_at_s", Double, nullable=False),
    Column("ended_at_s", Double),
    Index(None, "person_id"),
    comment="Links by which a person logs in once. ended_at_s: used or taken back.",
)

api_keys = Table(
    "api_keys",
    metadata,
    Column("id", Id, primary_key=True),
    Column("name", String(80), nullable=False),
    Column("token_hash", TokenHash, nullable=False),
    Column("scopes", Text, nullable=False),
    Column("created_at_s", Double, nullable=False),
    *(Column(name, Double) for name in ("expires_at_s", "revoked_at_s", "used_at_s")),
    # The transports that it may call for; names separated by spaces, empty for all.
    *(Column(name, Text, nullable=False, server_default="") for name in ("places", "items")),
    Column("open_max", Integer, nullable=False, server_default="50"),
    Column("open_each_max", Integer, nullable=False, server_default="20"),
    Column("priority", String(8), nullable=False, server_default="normal"),
    UniqueConstraint("token_hash"),
    comment="Keys of other systems. scopes: their names, with spaces between them.",
)

lockouts = Table(
    "lockouts",
    metadata,
    Column("subject", TokenHash, primary_key=True),
    Column("failures", Integer, nullable=False),
    Column("failed_at_s", Double, nullable=False),
    Column("until_s", Double, nullable=False),
    Index(None, "failed_at_s"),
    comment="Failed logins by the SHA-256 of the name that was given, whether anybody has it or not.",
)

# No foreign key to people: keys, the administrator and strangers are in it too.
audit = Table(
    "audit",
    metadata,
    Column("position", Position, primary_key=True, autoincrement=True),
    Column("at_s", Double, nullable=False),
    Column("who", Id, nullable=False),
    Column("who_kind", String(16), nullable=False),
    Column("from_ip", String(64), nullable=False),
    Column("session", Id, nullable=False),
    Column("action", String(64), nullable=False),
    Column("target", Id, nullable=False),
    Column("result", String(16), nullable=False),
    Column("detail", Text, nullable=False),
    Column("search", Text, nullable=False, server_default=""),
    CheckConstraint("result IN ('done', 'refused', 'failed')", name="result"),
    Index(None, "at_s"),
    Index(None, "who", "position"),
    Index(None, "action", "position"),
    Index(None, "target", "position"),
    sqlite_autoincrement=True,
    comment="Who did what, or tried to; detail is JSON.",
)

secrets = Table(
    "secrets",
    metadata,
    Column("name", String(64), primary_key=True),
    Column("value", Text, nullable=False),
    comment="Random values that are made once for this database.",
)

signing_keys = Table(
    "signing_keys",
    metadata,
    Column("id", Id, primary_key=True),
    Column("private_key", Text, nullable=False),
    Column("public_key", Text, nullable=False),
    Column("created_at_s", Double, nullable=False),
    Column("retired_at_s", Double),
    comment="Ed25519 keys, in hexadecimal digits, by which commands to vehicles are signed.",
)
