"""`dray carried-away`: report that a vehicle is off the floor or put back on it, without a panel, and read what has come of the reports.

The report goes into the database, and every gateway on it tells the plant. The replicas of the tables decide whether to accept it: not
while the vehicle is heard.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.commands.administration.shut_out import SEEN, Database

if TYPE_CHECKING:
    from dray.store.factory.removals import RemovalRow
    from dray.store.history.events import EventRow
    from dray.store.work import Work

FACTS = 1_000
"""Maximum answers of machines that are read, the newest ones."""


def carried_away(
    atv: Annotated[
        str | None,
        typer.Argument(
            help="Id of the vehicle, as ATV3, or of another agent that holds places; without one, lists what is off the floor, and which machines "
            "refuse to believe it, and why."
        ),
    ] = None,
    *,
    off_the_floor: Annotated[
        bool,
        typer.Option(
            "--off-the-floor", help="Somebody has seen that it stands on no lane. Others will drive there."
        ),
    ] = False,
    put_back: Annotated[
        str | None,
        typer.Option(
            "--put-back",
            help="Where a vehicle that was carried away is put back: a node or a place, as P2. It is reserved for it.",
        ),
    ] = None,
    plant: Annotated[
        Path | None,
        typer.Option(
            "--plant", help="With --put-back: the plant file; else DRAY_PLANT_FILE, else the default plant."
        ),
    ] = None,
    db: Database = None,
) -> None:
    """Report that a vehicle is off the floor: its places become free once it has been silent for a minute.

    With --put-back, reserve a place for it: put it down when the list says that the place is kept.
    """
    from dray.cli.commands.administration.console import note, transact
    from dray.errors import SettingsError
    from dray.plant.model import ID_RULE, is_id

    if atv is None:
        if off_the_floor or put_back is not None:
            raise SettingsError("ATV", "name the vehicle that is off the floor")
        _list(db)
        return
    if not is_id(atv):
        raise SettingsError("ATV", f"{atv!r} is no id; {ID_RULE}")
    if off_the_floor and put_back is not None:
        raise SettingsError("--put-back", "say first that it is off the floor, and then where it is put back")
    if put_back is not None:
        _put_back(atv, put_back, plant, db)
        return
    if not off_the_floor:
        raise SettingsError(
            "--off-the-floor",
            f"say it when somebody has seen that {atv} stands on no lane: others will drive there; "
            "or say with --put-back where it is put back",
        )

    async def say(work: Work) -> None:
        await work.removals.put(_statement(atv, ""))
        await note(work, "vehicle.carry_away", atv)

    transact(db, say)
    typer.echo(
        f"{atv} is said to be off the floor; {SEEN}, and drop it if {atv} is heard. "
        "`dray carried-away` lists what is free since, and who refuses to believe it"
    )


def _statement(atv: str, node: str) -> RemovalRow:
    """A statement about a vehicle, from here; a gateway adds the last heartbeat."""
    from dray.cli.commands.administration.console import account
    from dray.store.factory.removals import FROM_CONSOLE, RemovalRow

    who = account() or "console"
    return RemovalRow(
        atv=atv,
        number=0,
        life=0,
        seq=0,
        node=node,
        areas="null",
        by=who,
        person=FROM_CONSOLE + who,
        at_s=time.time(),
    )


def _put_back(atv: str, place: str, plant: Path | None, db: str | None) -> None:
    """Reserve a place for a vehicle that was carried away."""
    from dray.cli.commands.administration.console import note, transact
    from dray.errors import SettingsError

    node = _node(place, plant)

    async def say(work: Work) -> None:
        if all(each.atv != atv for each in await work.removals.all()):
            raise SettingsError(
                "ATV",
                f"nobody has said that {atv} was carried away, or it was heard since; "
                f"first `dray carried-away {atv} --off-the-floor`",
            )
        await work.removals.put(_statement(atv, node))
        await note(work, "vehicle.put_back", atv, place=place)

    transact(db, say)
    typer.echo(
        f"{node} is asked for, for {atv}; {SEEN}. "
        f"Put it down when `dray carried-away` says that {node} is kept for it, and not before"
    )


def _node(place: str, plant: Path | None) -> str:
    """The node of a place.

    Raises:
        SettingsError: there is no such place, or no vehicle may stand there.
    """
    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.options import load_settings
    from dray.errors import SettingsError

    chosen = chosen_plant(load_settings(plant_file=plant).plant_file)
    if place not in chosen.nodes and place not in chosen.places and place not in chosen.dwell_points:
        raise SettingsError(
            "--put-back", f"there is no node or place {place!r} in {chosen.id}; --plant names another file"
        )
    node = place if place in chosen.nodes else chosen.node_of(place)
    if node not in chosen.stops:
        raise SettingsError("--put-back", f"{node} lies in a crossing, where no vehicle stops; name another")
    return node


def _list(db: str | None) -> None:
    from dray.cli.commands.administration.console import transact
    from dray.cli.runtime.output import table
    from dray.messages.fact import PlaceKept, PlacesFreed, RemovalRefused
    from dray.store.history.events import EventFilter

    async def read(work: Work) -> tuple[list[RemovalRow], list[EventRow]]:
        wanted = EventFilter(kinds=(PlacesFreed.__name__, PlaceKept.__name__, RemovalRefused.__name__))
        return await work.removals.all(), await work.events.page(wanted, None, FACTS, newest_first=True)

    reports, answers = transact(db, read)
    rows = [
        (
            each.atv,
            each.node or "-",
            each.by,
            f"{datetime.fromtimestamp(each.at_s, UTC):%Y-%m-%d %H:%M}",
            "\n".join(_answers(each, reversed(answers))) or "no answer yet",
        )
        for each in reports
    ]
    table(("vehicle", "put back at", "said by", "UTC", "answers"), rows)


def _answers(report: RemovalRow, answers: Iterable[EventRow]) -> list[str]:
    """What machines have answered to a report, in order, for people."""
    import msgspec

    from dray.gateway.live.reasons import REMOVAL_REFUSALS
    from dray.messages.fact import PlaceKept, PlacesFreed, RemovalRefused

    words: list[str] = []
    for each in answers:
        try:
            fact = msgspec.json.decode(each.fact, type=PlacesFreed | PlaceKept | RemovalRefused)
        except msgspec.MsgspecError:
            continue  # It was written by another version of Dray.
        if (fact.atv, fact.number) != (report.atv, report.number):
            continue
        if isinstance(fact, PlacesFreed):
            words.append(f"{each.agent}: {', '.join(fact.places)} free")
        elif isinstance(fact, PlaceKept):
            words.append(f"{each.agent}: {fact.place} is kept for it, put it down there")
        else:
            words.append(f"{each.agent}: {REMOVAL_REFUSALS[fact.reason]}")
    return words
