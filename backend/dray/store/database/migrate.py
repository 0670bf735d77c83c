"""Migrations: upgrading the tables, or downgrading them.

The scripts are in `migrations/` at the top of a checkout, and inside `dray.store` in a wheel. Alembic is imported only for a
migration: many processes that read rows never need it, such as those beside a gateway.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import Connection

from dray.errors import UnavailableError
from dray.store.database.database import Database

if TYPE_CHECKING:
    from alembic.config import Config

CONNECTION = "connection"
"""The name under which the migrations' `env.py` finds the connection."""


def migrations_folder() -> Path:
    """The folder of the migration scripts.

    Raises:
        UnavailableError: this installation lacks them.
    """
    here = Path(__file__).resolve()
    for folder in (here.parents[1] / "migrations", here.parents[4] / "migrations"):
        if (folder / "env.py").is_file():
            return folder
    raise UnavailableError("migrations", f"there are none in {here.parents[1]}", "install Dray again")


def configuration() -> Config:
    """Alembic's configuration, built in code so that no file is needed."""
    from alembic.config import Config  # noqa: PLC0415 (see above)

    config = Config()
    config.set_main_option("script_location", str(migrations_folder()).replace("%", "%%"))
    return config


async def upgrade(database: Database, revision: str = "head") -> None:
    """Upgrade the tables to `revision`; does nothing when they have it.

    Raises:
        UnavailableError: the database was written by a newer Dray.
    """
    from alembic import command  # noqa: PLC0415 (see above)

    await _run(database, lambda config: command.upgrade(config, revision))


async def downgrade(database: Database, revision: str) -> None:
    """Downgrade the tables to `revision`; ``base`` removes them all."""
    from alembic import command  # noqa: PLC0415 (see above)

    await _run(database, lambda config: command.downgrade(config, revision))


async def revisions(database: Database) -> tuple[str | None, str | None, bool]:
    """The present state of the tables; changes nothing.

    Returns:
        The revision of the tables, None for no tables; the newest one; and whether this software knows the former.

    Raises:
        UnavailableError: reading failed, or the migrations are missing.
    """
    from alembic.runtime.migration import MigrationContext  # noqa: PLC0415 (see above)
    from alembic.script import ScriptDirectory  # noqa: PLC0415 (see above)

    scripts = ScriptDirectory.from_config(configuration())

    def found(connection: Connection) -> str | None:
        return MigrationContext.configure(connection).get_current_revision()

    async with database.read() as connection:
        current = await connection.run_sync(found)
    known = {script.revision for script in scripts.walk_revisions()}
    return current, scripts.get_current_head(), current is None or current in known


async def _run(database: Database, order: Callable[[Config], None]) -> None:
    from alembic.util import CommandError  # noqa: PLC0415 (see above)

    def with_connection(connection: Connection) -> None:
        config = configuration()
        config.attributes[CONNECTION] = connection
        order(config)

    try:
        async with database.write() as connection:
            await connection.run_sync(with_connection)
    except CommandError as error:
        raise UnavailableError(
            f"database {database.name}",
            f"its tables cannot be brought up to date: {error}",
            "it may be of a newer Dray: install that one, or name another file with --db",
        ) from error
