"""`dray link`: customers' links to the pages of their orders."""

from __future__ import annotations

import time
from typing import Annotated

import typer

app = typer.Typer(no_args_is_help=True, help="Customers' links to the pages of their orders.")

Database = Annotated[
    str | None, typer.Option("--db", help="Its URL; else DRAY_DATABASE_URL, else sqlite:///dray.db.")
]

DAY_S = 86_400.0

LONGEST_DAYS = 3650
"""Ten years: whoever wants more wants a link without an end of its own."""


@app.callback()
def link() -> None:
    """Customers' links to the pages of their orders."""


@app.command()
def create(
    order: Annotated[str, typer.Argument(help="The order's id, as O-1M9K3X2A4-K7QM.")],
    days: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=LONGEST_DAYS,
            help="How long it leads there; else until a quarter after the order's end.",
        ),
    ] = None,
    url: Annotated[
        str | None,
        typer.Option(
            help="Where customers reach the gateway; else DRAY_HOST and DRAY_PORT, else http://127.0.0.1:8000."
        ),
    ] = None,
    db: Database = None,
) -> None:
    """Make another link to an order's page; it is printed once and kept nowhere."""
    import asyncio

    from dray.cli.options import load_settings

    settings = load_settings(database_url=db)
    base = (url or f"http://{settings.host}:{settings.port}").rstrip("/")
    token = asyncio.run(_create(settings.database_url, order, None if days is None else days * DAY_S))
    typer.echo(f"{base}/track/{token}")


# A token may begin with a dash.
@app.command(context_settings={"ignore_unknown_options": True, "help_option_names": ["--help"]})
def revoke(
    what: Annotated[str, typer.Argument(help="A link, its token, or an order's id for all of its links.")],
    db: Database = None,
) -> None:
    """Take links back: their pages say so from now on."""
    import asyncio

    from dray.cli.options import load_settings

    count = asyncio.run(_revoke(load_settings(database_url=db).database_url, what))
    typer.echo(f"{count} {'link' if count == 1 else 'links'} taken back")


async def _create(url: str, order_id: str, life_s: float | None) -> str:
    from dray.errors import SettingsError
    from dray.gateway.orderids import new_token
    from dray.store import open_store
    from dray.store.links import Link

    store = await open_store(url)
    try:
        token, now_s = new_token(), time.time()
        async with store.write() as work:
            if await work.orders.get(order_id) is None:
                raise SettingsError("ORDER", f"there is no order {order_id!r}; GET /api/orders lists them")
            ends_s = None if life_s is None else now_s + life_s
            await work.links.add(token, Link(order_id, now_s, expires_at_s=ends_s))
    finally:
        await store.close()
    return token


async def _revoke(url: str, what: str) -> int:
    from dray.errors import SettingsError
    from dray.store import open_store

    token, now_s = what.rstrip("/").rpartition("/")[2], time.time()
    store = await open_store(url)
    try:
        async with store.write() as work:
            if await work.orders.get(what) is not None:
                return await work.links.revoke_all(what, now_s)
            if await work.links.find(token) is None:
                raise SettingsError("WHAT", "it is neither an order's id nor a link to one")
            return await work.links.revoke(token, now_s)
    finally:
        await store.close()
