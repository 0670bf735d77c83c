"""`dray link`: customers' links to the pages of their orders."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dray.store.work import Work

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
    from dray.cli.commands.administration.console import note, transact
    from dray.cli.runtime.options import load_settings
    from dray.errors import SettingsError
    from dray.gateway.orders.order_ids import new_token
    from dray.store.orders.tracking_links import WORKING_MAX, Link

    settings = load_settings(database_url=db)
    base = (url or f"http://{settings.host}:{settings.port}").rstrip("/")
    token, now_s = new_token(), time.time()

    async def keep(work: Work) -> None:
        if await work.orders.get(order) is None:
            raise SettingsError("ORDER", f"there is no order {order!r}; GET /api/orders lists them")
        ends_s = None if days is None else now_s + days * DAY_S
        if not await work.links.add_another(token, Link(order, now_s, expires_at_s=ends_s)):
            raise SettingsError(
                "ORDER",
                f"{WORKING_MAX} links lead to its page already: `dray link revoke {order}` takes them back",
            )
        await note(work, "link.create", order, days=days)

    transact(db, keep)
    typer.echo(f"{base}/track/{token}")


# A token may begin with a dash.
@app.command(context_settings={"ignore_unknown_options": True, "help_option_names": ["--help"]})
def revoke(
    what: Annotated[str, typer.Argument(help="A link, its token, or an order's id for all of its links.")],
    db: Database = None,
) -> None:
    """Take links back: their pages say so from now on."""
    from dray.cli.commands.administration.console import note, transact
    from dray.errors import SettingsError

    token, now_s = what.rstrip("/").rpartition("/")[2], time.time()

    async def take_back(work: Work) -> int:
        if await work.orders.get(what) is not None:
            order, count = what, await work.links.revoke_all(what, now_s)
        elif (link := await work.links.find(token)) is not None:
            order, count = link.subject, await work.links.revoke(token, now_s)
        else:
            raise SettingsError("WHAT", "it is neither an order's id nor a link to one")
        if count:
            # Of a token nothing is written down: it opens a page, or has opened one.
            await note(work, "link.revoke", order, links=count)
        return count

    count = transact(db, take_back)
    typer.echo(f"{count} {'link' if count == 1 else 'links'} taken back")
