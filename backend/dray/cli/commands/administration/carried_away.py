"""`dray carried-away`: report that a vehicle is off the floor, without a panel.

The report goes into the database, and every gateway on it tells the plant. The replicas of the tables decide whether to accept it: not
while the vehicle is heard.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.commands.administration.shut_out import SEEN, Database

if TYPE_CHECKING:
    from dray.store.work import Work


def carried_away(
    atv: Annotated[str, typer.Argument(help="The vehicle, or whoever holds places: its id, as ATV3.")],
    *,
    off_the_floor: Annotated[
        bool,
        typer.Option(
            "--off-the-floor", help="Somebody has seen that it stands on no lane. Others will drive there."
        ),
    ] = False,
    db: Database = None,
) -> None:
    """Report that a vehicle is off the floor: its places become free once it has been silent for a minute."""
    from dray.cli.commands.administration.console import account, note, transact
    from dray.errors import SettingsError
    from dray.plant.model import ID_RULE, is_id
    from dray.store.factory.removals import FROM_CONSOLE, RemovalRow

    if not is_id(atv):
        raise SettingsError("ATV", f"{atv!r} is no id; {ID_RULE}")
    if not off_the_floor:
        raise SettingsError(
            "--off-the-floor",
            f"say it when somebody has seen that {atv} stands on no lane: others will drive there",
        )
    who = account() or "console"

    async def say(work: Work) -> None:
        await work.removals.put(
            RemovalRow(
                atv=atv,
                number=0,
                life=0,
                seq=0,
                node="",
                areas="null",
                by=who,
                person=FROM_CONSOLE + who,
                at_s=time.time(),
            )
        )
        await note(work, "vehicle.carry_away", atv)

    transact(db, say)
    typer.echo(f"{atv} is said to be off the floor; {SEEN}, and drop it if {atv} is heard")
