"""`dray user`: people and their logins."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dray.store.access.people import Person
    from dray.store.work import Work

app = typer.Typer(no_args_is_help=True, help="Who may log in, and by what.")

Database = Annotated[
    str | None,
    typer.Option("--db", help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db."),
]

Who = Annotated[str, typer.Argument(metavar="NAME", help="As `dray user list` shows it.")]

HOUR_S = 3600.0

LONGEST_LINK_H = 24 * 14
"""Maximum validity: two weeks, because a person may be on holiday."""


@app.callback()
def user() -> None:
    """People and their logins."""


@app.command()
def add(
    name: Annotated[str, typer.Argument(help="What is typed to log in: small letters, digits, . _ and -.")],
    role: Annotated[str, typer.Option(help="manager or operator.")] = "operator",
    called: Annotated[str, typer.Option(help="What people call them; else NAME.")] = "",
    area: Annotated[list[str] | None, typer.Option(help="Where an operator works; may be repeated.")] = None,
    plant: Annotated[
        Path | None,
        typer.Option(help="The plant file with these areas; else DRAY_PLANT_FILE, else the default plant."),
    ] = None,
    db: Database = None,
) -> None:
    """Add a person; give them a link, a password, a PIN or a badge afterwards."""
    from dray.cli.commands.administration.console import note, transact
    from dray.cli.runtime.output import one_of
    from dray.errors import SettingsError
    from dray.gateway.access.people_changes import LOGIN_NAME
    from dray.gateway.access.principal import Role
    from dray.store.access.people import Person

    one_of({each.value: each for each in Role}, role, "--role")
    if not LOGIN_NAME.fullmatch(name):
        raise SettingsError(
            "NAME", f"{name!r} is not small letters, digits, . _ and - that begin with one of the first two"
        )
    areas = _areas(area or [], role, plant)
    person = Person(id=name, name=called or name, role=role, created_at_s=time.time(), areas=areas)

    async def keep(work: Work) -> None:
        if await work.people.get(name) is not None:
            raise SettingsError(
                "NAME", f"there is a {name!r} already; nobody ever gets the name of another one"
            )
        await work.people.add(person)
        await note(work, "user.add", name, role=role, areas=list(areas))

    transact(db, keep)
    typer.echo(f"{name} may log in: dray user link {name}")


@app.command("list")
def list_users(db: Database = None) -> None:
    """List the people who may log in."""
    from dray.cli.commands.administration.console import transact
    from dray.cli.runtime.output import table

    async def people(work: Work) -> list[Person]:
        return await work.people.all()

    rows = [
        (
            each.id,
            each.name,
            each.role,
            ", ".join(each.areas) or ("everywhere" if each.role == "manager" else "nowhere"),
            ", ".join(_secrets(each)) or "by link only",
            "" if each.disabled_at_s is None else "disabled",
        )
        for each in transact(db, people)
    ]
    table(("name", "called", "role", "areas", "logs in by", ""), rows)


@app.command()
def password(name: Who, db: Database = None) -> None:
    """Give a manager a password; asks for it, or reads one line from a pipe."""
    from dray.gateway.access.login.hasher import Hasher
    from dray.gateway.access.login.secrets import check_password

    _expect(db, name, "manager", "a password", "dray user pin")
    chosen = _ask("Password")
    check_password(chosen, name)
    _change(db, name, "user.password", password_hash=Hasher().hash(chosen))
    typer.echo(f"{name} logs in with the new password; all earlier logins have ended")


@app.command()
def pin(name: Who, db: Database = None) -> None:
    """Give an operator a PIN; asks for it, or reads one line from a pipe."""
    from dray.gateway.access.login.hasher import Hasher
    from dray.gateway.access.login.secrets import check_pin

    _expect(db, name, "operator", "a PIN", "dray user password")
    chosen = _ask("PIN")
    check_pin(chosen)
    _change(db, name, "user.pin", pin_hash=Hasher().hash(chosen))
    typer.echo(f"{name} logs in with the new PIN; all earlier logins have ended")


@app.command()
def badge(
    name: Who,
    read: Annotated[
        bool, typer.Option(help="Ask for the code of a badge that there is; else a new code is printed.")
    ] = False,
    db: Database = None,
) -> None:
    """Give an operator a badge."""
    from dray.cli.commands.administration.console import transact
    from dray.gateway.access.login.hasher import Hasher
    from dray.gateway.access.login.login import BADGE_SALT
    from dray.gateway.access.login.secrets import check_badge
    from dray.gateway.access.tokens import new_token

    _expect(db, name, "operator", "a badge", "dray user password")
    code = _ask("Badge") if read else new_token()
    check_badge(code)

    async def salt(work: Work) -> str:
        return await work.secrets.get(BADGE_SALT)

    _change(db, name, "user.badge", badge_hash=Hasher().badge_hash(code, transact(db, salt)))
    typer.echo(f"{name} logs in with this badge" if read else code)


@app.command()
def link(
    name: Who,
    hours: Annotated[int, typer.Option(min=1, max=LONGEST_LINK_H, help="Hours for which it works.")] = 24,
    url: Annotated[
        str | None,
        typer.Option(
            help="Where the panel is; else DRAY_PUBLIC_URL, else where the gateway of the database is."
        ),
    ] = None,
    db: Database = None,
) -> None:
    """Print a link that logs a person in once; earlier ones become invalid."""
    from dray.cli.commands.administration.console import note, reached_at, transact
    from dray.gateway.access.login.invitations import invite

    async def make(work: Work) -> str:
        await _known(work, name)
        await note(work, "user.link", name, hours=hours)
        token = await invite(work, name, time.time(), hours * HOUR_S)
        return f"{await reached_at(work, url)}/login/{token}"

    typer.echo(transact(db, make))


@app.command()
def disable(name: Who, db: Database = None) -> None:
    """Disable a person's login, at once and everywhere."""
    _change(db, name, "user.disable", disabled_at_s=time.time())
    typer.echo(f"{name} may not log in any more, and is logged out everywhere")


@app.command()
def enable(name: Who, db: Database = None) -> None:
    """Enable a person's login again."""
    _change(db, name, "user.enable", disabled_at_s=None)
    typer.echo(f"{name} may log in again")


def _areas(areas: list[str], role: str, plant: Path | None) -> tuple[str, ...]:
    """The areas, which must be in the plant, and which an operator needs."""
    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.options import load_settings
    from dray.errors import SettingsError

    if role == "manager":
        if areas:
            raise SettingsError("--area", "a manager works everywhere; leave it out")
        return ()
    known = chosen_plant(load_settings(plant_file=plant).plant_file).areas
    unknown = [area for area in areas if area not in known]
    if unknown or not areas:
        wrong = f"there is no {unknown[0]!r}" if unknown else "an operator needs one"
        raise SettingsError(
            "--area", f"{wrong}; choose of {', '.join(known)}, or name another plant with --plant"
        )
    return tuple(dict.fromkeys(areas))


def _secrets(person: Person) -> list[str]:
    kept = {"password": person.password_hash, "PIN": person.pin_hash, "badge": person.badge_hash}
    return [name for name, value in kept.items() if value]


def _ask(what: str) -> str:
    """A secret, typed twice without an echo; or one line of a pipe."""
    import sys

    if sys.stdin.isatty():
        return str(typer.prompt(what, hide_input=True, confirmation_prompt=True))
    return sys.stdin.readline().rstrip("\r\n")


def _expect(db: str | None, name: str, role: str, what: str, instead: str) -> None:
    """Check the person's role before anything is typed."""
    from dray.cli.commands.administration.console import transact
    from dray.errors import SettingsError

    async def get(work: Work) -> Person:
        return await _known(work, name)

    if transact(db, get).role != role:
        raise SettingsError("NAME", f"{what} is for {role}s; see `{instead}`")


def _change(db: str | None, name: str, action: str, **columns: object) -> None:
    """Change a person; their sessions end."""
    from dray.cli.commands.administration.console import note, transact
    from dray.errors import SettingsError
    from dray.gateway.access import people_changes

    async def change(work: Work) -> None:
        await _known(work, name)
        code = columns.get("badge_hash")
        if isinstance(code, str) and (other := await work.people.with_badge(code)) and other.id != name:
            raise SettingsError("NAME", "somebody else has this badge already")
        await people_changes.change(work, name, time.time(), **columns)
        await note(work, action, name)

    transact(db, change)


async def _known(work: Work, name: str) -> Person:
    from dray.errors import SettingsError

    person = await work.people.get(name)
    if person is None:
        raise SettingsError("NAME", f"there is no {name!r}; `dray user list` shows who there is")
    return person
