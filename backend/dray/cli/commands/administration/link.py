"""`dray link`: links to the pages of orders and of plain transports, for customers and others."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dray.store.orders.tracking_links import Links
    from dray.store.work import Work

app = typer.Typer(no_args_is_help=True, help="Links to the pages of orders and plain transports.")

Database = Annotated[
    str | None,
    typer.Option("--db", help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db."),
]

DAY_S = 86_400.0

LONGEST_DAYS = 3650
"""Maximum validity: ten years; a longer one needs a link without an end of its own."""

NEWEST_SHOWN = 5
"""Maximum orders, and transports, named where an id is unknown."""


@app.callback()
def link() -> None:
    """Links to the pages of orders and plain transports."""


@app.command()
def create(
    to: Annotated[
        str,
        typer.Argument(
            metavar="ORDER|TRANSPORT",
            help="The order's id, as O-1M9K3X2A4-K7QM, or the plain transport's, as T-1M9K3X2A4-K7QM.",
        ),
    ],
    days: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=LONGEST_DAYS,
            help="Days for which it works; else until 90 days after the end of the order or transport.",
        ),
    ] = None,
    url: Annotated[
        str | None,
        typer.Option(
            help="Where its readers reach the gateway; else DRAY_PUBLIC_URL, else where the gateway of the database is."
        ),
    ] = None,
    db: Database = None,
) -> None:
    """Create another link to the page of an order or a plain transport; it is printed once and stored nowhere."""
    from dray.cli.commands.administration.console import note, reached_at, transact
    from dray.errors import SettingsError
    from dray.gateway.orders.order_ids import new_token
    from dray.store.orders.tracking_links import WORKING_MAX, Link

    token, now_s = new_token(), time.time()

    async def keep(work: Work) -> str:
        links = await _links_of(work, to)
        if links is None:
            raise SettingsError("ORDER|TRANSPORT", await _unknown(work, to))
        ends_s = None if days is None else now_s + days * DAY_S
        if not await links.add_another(token, Link(to, now_s, expires_at_s=ends_s)):
            raise SettingsError(
                "ORDER|TRANSPORT",
                f"{WORKING_MAX} links lead to its page already: `dray link revoke {to}` takes them back",
            )
        await note(work, "link.create", to, days=days)
        return await reached_at(work, url)

    typer.echo(f"{transact(db, keep)}/track/{token}")


# A token may begin with a dash.
@app.command(context_settings={"ignore_unknown_options": True, "help_option_names": ["--help"]})
def revoke(
    what: Annotated[
        str, typer.Argument(help="A link, its token, or an order's or transport's id for all of its links.")
    ],
    db: Database = None,
) -> None:
    """Revoke links: their pages say so from now on."""
    from dray.cli.commands.administration.console import note, transact

    token, now_s = what.rstrip("/").rpartition("/")[2], time.time()

    async def take_back(work: Work) -> int:
        links, subject = await _links_of(work, what), what
        if links is not None:
            count = await links.revoke_all(what, now_s)
        else:
            links, subject = await _links_with(work, token)
            count = await links.revoke(token, now_s)
        if count:
            # The audit log never contains a token: it opens a page, or has opened one.
            await note(work, "link.revoke", subject, links=count)
        return count

    count = transact(db, take_back)
    typer.echo(f"{count} {'link' if count == 1 else 'links'} taken back")


async def _links_of(work: Work, subject: str) -> Links | None:
    """The repository of links to orders or to transports, by the kind of subject; None for an unknown subject."""
    if await work.orders.get(subject) is not None:
        return work.links
    if await work.transports.get(subject) is not None:
        return work.transport_links
    return None


async def _unknown(work: Work, subject: str) -> str:
    """The text about an unknown subject, with the newest ones."""
    from dray.store.orders.order_filter import OrderFilter
    from dray.store.orders.transports import TransportFilter

    newest = [each.id for each in await work.orders.page(OrderFilter(), None, NEWEST_SHOWN)]
    newest += [each.id for each in await work.transports.page(TransportFilter(), None, NEWEST_SHOWN)]
    here = (
        f"the newest are {', '.join(newest)}"
        if newest
        else "this database has none; is it the gateway's (--db)?"
    )
    return (
        f"there is no order and no transport {subject!r}; {here}. The management panel's lists of orders and "
        "transports have all ids, and so have GET /api/orders and GET /api/transports"
    )


async def _links_with(work: Work, token: str) -> tuple[Links, str]:
    """The repository with a token's link, and the link's subject.

    Raises:
        SettingsError: no link has it.
    """
    from dray.errors import SettingsError

    for links in (work.links, work.transport_links):
        if (link := await links.find(token)) is not None:
            return links, link.subject
    raise SettingsError("WHAT", "it is neither an order's or transport's id nor a link to one")
