"""Alembic's entry: runs the migrations on the connection that Dray hands over (`dray db upgrade`)."""

from __future__ import annotations

from alembic import context

from dray.store.tables import metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    # SQLite changes a column by copying its table.
    render_as_batch=True,
)
with context.begin_transaction():
    context.run_migrations()
