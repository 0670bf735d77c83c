"""`dray certs`: certificates for the agents of a plant, and the authority that signs them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from dray.adapters.security.certificates import Authority

app = typer.Typer(no_args_is_help=True, help="Certificates for the agents of a plant.")

Folder = Annotated[Path, typer.Argument(help="The folder of the certificates.")]
PlantFile = Annotated[
    Path | None, typer.Option("--plant", help="A plant file; else DRAY_PLANT_FILE, else the default plant.")
]
Days = Annotated[
    int | None, typer.Option(min=1, max=3650, help="Days for which they are valid; else a year and a month.")
]


@app.callback()
def certs() -> None:
    """Certificates for the agents of a plant."""


@app.command()
def make(folder: Folder, plant: PlantFile = None, days: Days = None) -> None:
    """Make an authority, and a certificate for every agent of the plant.

    Each computer gets authority.pem and the two files of its own agent. The key of the authority,
    authority.key, belongs on none of them.
    """
    from dray.adapters.security.certificates import AUTHORITY, DAYS, Authority
    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.roster import certified_of
    from dray.errors import SettingsError
    from dray.messages.keys import strategists_of

    settings = load_settings(plant_file=plant)
    chosen = chosen_plant(settings.plant_file)
    if (folder / f"{AUTHORITY}.pem").exists():
        raise SettingsError(
            str(folder), "has an authority already; `dray certs issue` uses it, or choose another folder"
        )
    processes = certified_of(chosen, strategists_of(settings.strategists), "gateway")
    with _writing_into(folder):
        authority = Authority.make(chosen.id)
        authority.write(folder)
        for agents in processes.values():
            authority.issue(folder, chosen.id, agents, days=days or DAYS)
    typer.echo(f"{folder}: an authority and {len(processes)} certificates for {chosen.id}")


@app.command()
def issue(
    folder: Folder,
    kind: Annotated[
        str,
        typer.Argument(
            help="What the agent is: atv, machine, station, gate, strategist, gateway or historian."
        ),
    ],
    agent: Annotated[str, typer.Argument(help="Its id.")],
    plant: Annotated[
        Path | None,
        typer.Option("--plant", help="A plant file, when the authority's certificate names no plant."),
    ] = None,
    days: Days = None,
) -> None:
    """Make a certificate for one agent, with the authority of that folder and for its plant."""
    from dray.adapters.security.certificates import DAYS, Authority
    from dray.cli.runtime.output import one_of
    from dray.messages.kinds import Kind
    from dray.messages.speakers import names_of

    chosen = one_of({str(each): each for each in Kind}, kind, "KIND")
    authority = Authority.load(folder)
    with _writing_into(folder):
        authority.issue(folder, _plant_of(authority, plant), names_of(agent, chosen), days=days or DAYS)
    typer.echo(f"{folder / agent}.pem")


@app.command()
def revoke(
    folder: Folder,
    agent: Annotated[str, typer.Argument(help="The id of the agent whose certificates are revoked.")],
    reason: Annotated[
        str, typer.Option(help="key-compromise, superseded, cessation-of-operation or unspecified.")
    ],
) -> None:
    """Revoke all certificates issued so far for an agent; then copy revoked.pem to every computer.

    Running processes notice the changed file within some seconds. Certificates issued later are valid.
    """
    from dray.adapters.security.certificates import Authority
    from dray.adapters.security.revocations import FILE, REASONS, call_back
    from dray.cli.runtime.output import one_of

    one_of(REASONS, reason, "--reason")
    authority = Authority.load(folder)
    with _writing_into(folder):
        count = call_back(authority, folder, agent, reason)
    told = (
        f"{count} {'certificate' if count == 1 else 'certificates'} of {agent} revoked"
        if count
        else (f"{agent}: all its certificates were revoked already")
    )
    typer.echo(f"{told}; copy {folder / FILE} beside authority.pem on every computer")


def _plant_of(authority: Authority, file: Path | None) -> str:
    """The id of the plant for which an authority issues certificates.

    Raises:
        PlantError: the plant file cannot be used.
        SettingsError: the authority belongs to another plant.
    """
    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.options import load_settings
    from dray.errors import SettingsError

    if file is None and authority.plant:
        return authority.plant
    plant = chosen_plant(load_settings(plant_file=file).plant_file).id
    if authority.plant not in {"", plant}:
        reason = f"{file} is of the plant {plant}, and the authority of {authority.plant}; leave it out"
        raise SettingsError("--plant", reason)
    return plant


@contextmanager
def _writing_into(folder: Path) -> Iterator[None]:
    from dray.errors import UnavailableError

    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise UnavailableError(str(folder), reason, "choose a folder that can be written") from None
