"""`dray key`: API keys of other systems."""

from __future__ import annotations

import re
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dray.store.access.api_keys import ApiKey
    from dray.store.work import Work

app = typer.Typer(no_args_is_help=True, help="Keys by which other systems use the API.")

Database = Annotated[
    str | None,
    typer.Option("--db", help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db."),
]

DAY_S = 86_400.0

LONGEST_DAYS = 3650
"""Maximum validity: ten years; a longer one needs a key without an end."""

NAME_CHARS = 80

NAMES_MAX = 100
"""Maximum places or materials of a key."""

NAMED_MAX = 30
"""Maximum names in a message: more are not read in a terminal."""

OPEN_MOST = 1_250
"""Maximum open transports of a caller (`dray.gateway.routes.keys.KEY_OPEN_MOST`)."""

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,31}")


@app.callback()
def key() -> None:
    """API keys of other systems."""


@app.command()
def create(
    name: Annotated[str, typer.Argument(help="What the key is for, as ERP.")],
    scope: Annotated[list[str], typer.Option(help="What it may do, as orders:write; may be repeated.")],
    days: Annotated[
        int | None,
        typer.Option(min=1, max=LONGEST_DAYS, help="Days for which it works; else until it is revoked."),
    ] = None,
    place: Annotated[
        list[str] | None,
        typer.Option(help="A machine or storage for which alone it calls for transports; may be repeated."),
    ] = None,
    item: Annotated[
        list[str] | None,
        typer.Option(help="A material for which alone it calls for transports; may be repeated."),
    ] = None,
    open_max: Annotated[
        int | None,
        typer.Option(
            "--open", min=1, max=OPEN_MOST, help="Number of its transports that may be open at once; else 50."
        ),
    ] = None,
    open_each_max: Annotated[
        int | None,
        typer.Option("--open-each", min=1, max=OPEN_MOST, help="The same for one place; else 20."),
    ] = None,
    priority: Annotated[
        str | None,
        typer.Option(help="The highest with which it calls for transports; else normal."),
    ] = None,
    plant: Annotated[
        Path | None,
        typer.Option(
            help="The plant file with these places and materials; else DRAY_PLANT_FILE, else the default plant."
        ),
    ] = None,
    db: Database = None,
) -> None:
    """Create a key; it is printed once and stored nowhere."""
    from dray.cli.commands.administration.console import note, transact
    from dray.cli.runtime.output import one_of
    from dray.errors import SettingsError
    from dray.gateway.access.principal import Scope
    from dray.gateway.access.tokens import new_id, new_key
    from dray.priorities import Priority
    from dray.store.access.api_keys import OPEN_EACH_MAX, OPEN_MAX, ApiKey

    known = {each.value: each for each in Scope}
    scopes = [one_of(known, each, "--scope").value for each in dict.fromkeys(scope)]
    if not (name.isprintable() and name.strip() and len(name) <= NAME_CHARS):
        raise SettingsError("NAME", f"it has 1 to {NAME_CHARS} characters that can be printed")
    places, items = list(dict.fromkeys(place or [])), list(dict.fromkeys(item or []))
    limits = {"--place": places, "--item": items, "--open": open_max, "--open-each": open_each_max}
    for option, given in (limits | {"--priority": priority}).items():
        if given and Scope.TRANSPORTS_CALL.value not in scopes:
            raise SettingsError(option, f"it is of keys with the scope {Scope.TRANSPORTS_CALL.value}")
    for option, names in (("--place", places), ("--item", items)):
        if len(names) > NAMES_MAX or not all(map(NAME.fullmatch, names)):
            raise SettingsError(option, f"name at most {NAMES_MAX} by their ids in the plant, as M8 or shaft")
    if places or items:
        _known_in(plant, places, items)
    priorities = {each.value: each for each in Priority}
    highest = Priority.NORMAL if priority is None else one_of(priorities, priority, "--priority")
    at_once = open_max or OPEN_MAX
    if open_each_max is not None and open_each_max > at_once:
        raise SettingsError("--open-each", f"it is more than of all places together, {at_once}")
    at_one = open_each_max or min(OPEN_EACH_MAX, at_once)
    now_s, token = time.time(), new_key()
    made = ApiKey(
        id=new_id(),
        name=name,
        scopes=" ".join(scopes),
        created_at_s=now_s,
        expires_at_s=None if days is None else now_s + days * DAY_S,
        places=" ".join(places),
        items=" ".join(items),
        open_max=at_once,
        open_each_max=at_one,
        priority=highest.value,
    )
    detail = {"name": name, "scopes": scopes, "days": days}
    if Scope.TRANSPORTS_CALL.value in scopes:
        detail |= {"places": places, "items": items}
        detail |= {"open": at_once, "open_each": at_one, "priority": highest.value}

    async def keep(work: Work) -> None:
        await work.api_keys.add(token, made)
        await note(work, "key.create", made.id, **detail)

    transact(db, keep)
    typer.echo(token)


@app.command("list")
def list_keys(db: Database = None) -> None:
    """List the keys."""
    from dray.cli.commands.administration.console import transact
    from dray.cli.runtime.output import table

    async def keys(work: Work) -> list[ApiKey]:
        return await work.api_keys.all()

    now_s = time.time()
    rows = [
        (
            each.id,
            each.name,
            _may(each),
            _day(each.used_at_s) or "never",
            _state(each, now_s),
        )
        for each in transact(db, keys)
    ]
    table(("id", "name", "scopes", "used", ""), rows)


@app.command()
def signing(db: Database = None) -> None:
    """Print the public key of gateways on this database for signed commands (DRAY_TRUSTED_KEYS)."""
    import asyncio

    from dray.cli.runtime.gateway.authority import authority_of
    from dray.cli.runtime.options import load_settings
    from dray.store import open_store

    async def ask() -> str:
        store = await open_store(load_settings(database_url=db).database_url)
        try:
            return (await authority_of(store)).public.hex()
        finally:
            await store.close()

    typer.echo(asyncio.run(ask()))


@app.command()
def revoke(
    key_id: Annotated[str, typer.Argument(metavar="ID", help="As `dray key list` shows it.")],
    db: Database = None,
) -> None:
    """Revoke a key: it opens nothing from now on."""
    from dray.cli.commands.administration.console import note, transact
    from dray.errors import SettingsError

    async def take_back(work: Work) -> bool:
        if await work.api_keys.get(key_id) is None:
            raise SettingsError("ID", f"there is no key {key_id!r}; `dray key list` shows those there are")
        done = await work.api_keys.revoke(key_id, time.time()) == 1
        if done:
            await note(work, "key.revoke", key_id)
        return done

    typer.echo("taken back" if transact(db, take_back) else "it was taken back already")


def _known_in(plant: Path | None, places: list[str], items: list[str]) -> None:
    """Refuse a key for places or materials that the plant does not have.

    Raises:
        SettingsError: names the first of them, and what there is.
    """
    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.options import load_settings
    from dray.errors import SettingsError

    chosen = chosen_plant(load_settings(plant_file=plant).plant_file)
    for option, names, known in (
        ("--place", places, (*chosen.machines, *chosen.stores)),
        ("--item", items, tuple(chosen.materials)),
    ):
        unknown = [name for name in names if name not in known]
        if unknown:
            more = f" and {len(known) - NAMED_MAX} more" if len(known) > NAMED_MAX else ""
            raise SettingsError(
                option,
                f"there is no {unknown[0]!r} in the plant {chosen.id}; it has {', '.join(known[:NAMED_MAX])}{more}. "
                "Name one of them, or another plant with --plant",
            )


def _may(key: ApiKey) -> str:
    """Its permissions and limits."""
    if "transports:call" not in key.scopes.split():
        return key.scopes
    within = [f"{key.open_max} open, {key.open_each_max} for a place, {key.priority} at the highest"]
    within += [f"at {key.places}"] if key.places else []
    within += [f"of {key.items}"] if key.items else []
    return f"{key.scopes} ({', '.join(within)})"


def _state(key: ApiKey, now_s: float) -> str:
    if key.revoked_at_s is not None:
        return f"taken back {_day(key.revoked_at_s)}"
    if key.expires_at_s is None:
        return ""
    return (
        f"until {_day(key.expires_at_s)}" if now_s < key.expires_at_s else f"ended {_day(key.expires_at_s)}"
    )


def _day(at_s: float | None) -> str:
    return "" if at_s is None else datetime.fromtimestamp(at_s, UTC).strftime("%Y-%m-%d")
