"""`dray db`: the database."""

from __future__ import annotations

from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="The database.")


@app.callback()
def db() -> None:
    """The database."""


@app.command()
def upgrade(
    db: Annotated[
        str | None, typer.Option(help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db.")
    ] = None,
) -> None:
    """Create or upgrade the tables; harmless when they are up to date."""
    import asyncio

    from dray.cli.runtime.options import load_settings

    asyncio.run(_upgrade(load_settings(database_url=db).database_url))


async def _upgrade(url: str) -> None:
    from sqlalchemy import make_url

    from dray.store import open_store

    store = await open_store(url)
    await store.close()
    typer.echo(f"{make_url(url).render_as_string(hide_password=True)}: up to date")
