"""`dray shut-out`, `dray readmit`: exclude an agent, so that nobody hears it, and readmit it.

The decision goes into the database, and every gateway on it tells the plant.
"""

from __future__ import annotations

import time
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dray.store.factory.exclusions import Exclusion
    from dray.store.work import Work

Database = Annotated[
    str | None,
    typer.Option("--db", help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db."),
]

SEEN = "gateways on this database tell everybody within two seconds; without one, as soon as one is started"

REASON_CHARS = 200


def shut_out(
    agent: Annotated[
        str | None, typer.Argument(help="Its id, as ATV3; without one, lists who is shut out.")
    ] = None,
    reason: Annotated[str, typer.Option(help="Why; panels and the audit log show it.")] = "",
    db: Database = None,
) -> None:
    """Exclude an agent, over restarts and without a gateway, until `dray readmit`: nobody hears it any more."""
    from dray.cli.commands.administration.console import account, note, transact
    from dray.errors import SettingsError
    from dray.messages.shutout import MAX_SHUT_OUT
    from dray.plant.model import ID_RULE, is_id
    from dray.store.factory.exclusions import Exclusion

    if agent is None:
        _list(db)
        return
    if not is_id(agent):
        raise SettingsError("AGENT", f"{agent!r} is no id; {ID_RULE}")
    if not (reason.isprintable() and reason.strip() and len(reason) <= REASON_CHARS):
        raise SettingsError("--reason", f"say why, in 1 to {REASON_CHARS} characters that can be printed")

    async def decide(work: Work) -> Exclusion | None:
        known = await work.exclusions.get(agent)
        if known is not None:
            return known
        if len(await work.exclusions.all()) >= MAX_SHUT_OUT:
            raise SettingsError("AGENT", f"{MAX_SHUT_OUT} are shut out, and no list holds more; readmit some")
        await work.exclusions.put(Exclusion(agent, reason, account() or "console", time.time()))
        await note(work, "agent.shut_out", agent, reason=reason)
        return None

    before = transact(db, decide)
    if before is None:
        typer.echo(f"{agent} is shut out; {SEEN}")
    else:
        typer.echo(f"{agent} was shut out already, by {before.by}: {before.reason}")


def readmit(
    agent: Annotated[str, typer.Argument(help="Its id, as `dray shut-out` lists it.")],
    db: Database = None,
) -> None:
    """Readmit an excluded agent. A vehicle stays stopped until a person acknowledges and resumes it."""
    from dray.cli.commands.administration.console import note, transact
    from dray.errors import SettingsError

    async def decide(work: Work) -> None:
        known = await work.exclusions.get(agent)
        if known is None:
            raise SettingsError("AGENT", f"{agent!r} is not shut out; `dray shut-out` lists who is")
        await work.exclusions.end(agent, time.time())
        await note(work, "agent.readmit", agent, shut_out_for=known.reason)

    transact(db, decide)
    typer.echo(f"{agent} is readmitted; {SEEN}")


def _list(db: str | None) -> None:
    from dray.cli.commands.administration.console import transact
    from dray.cli.runtime.output import table

    async def read(work: Work) -> list[Exclusion]:
        return await work.exclusions.all()

    rows = [
        (each.agent, each.by, f"{datetime.fromtimestamp(each.at_s, UTC):%Y-%m-%d %H:%M}", each.reason)
        for each in transact(db, read)
    ]
    table(("agent", "shut out by", "UTC", "reason"), rows)
