"""`dray plant ready`: what a real plant still lacks for service."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.runtime.options import SettingsFile

if TYPE_CHECKING:
    from dray.settings import Settings


def ready(
    file: Annotated[Path, typer.Argument(help="A plant file (YAML), or the name of a shipped plant.")],
    gateway: Annotated[
        str | None,
        typer.Option(
            "--gateway",
            "--url",
            help="Where the gateway is; else DRAY_HOST and DRAY_PORT, else http://127.0.0.1:8000.",
        ),
    ] = None,
    token: Annotated[
        str | None,
        typer.Option(help="The administrator's token, or a key with people:write; else DRAY_ADMIN_TOKEN."),
    ] = None,
    certificates: Annotated[
        Path | None,
        typer.Option(help="The folder where `dray certs` made them; else DRAY_BUS_CERTIFICATES."),
    ] = None,
    mappings: Annotated[
        Path | None,
        typer.Option(help="The folder of the controllers' mapping files, called as M8.yaml or gate.yaml."),
    ] = None,
    db: Annotated[
        str | None,
        typer.Option("--db", help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db."),
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write the findings here too.")] = None,
    settings: SettingsFile = None,
) -> None:
    """Say what a plant still lacks for service; changes nothing. Exit code 1: something is missing."""
    import asyncio
    import time

    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.output import write_json
    from dray.cli.runtime.ready.computer import free_on, ntp_synchronised
    from dray.cli.runtime.ready.finding import Verdict
    from dray.cli.runtime.ready.report import Viewpoint, findings, lines
    from dray.cli.runtime.rest_client import RestClient
    from dray.errors import SettingsError
    from dray.plant import load_plant

    said = load_settings(settings_file=settings, database_url=db, admin_token=token)
    plant = load_plant(file)
    for option, folder in (("--certificates", certificates), ("--mappings", mappings)):
        if folder is not None and not folder.is_dir():
            raise SettingsError(option, f"there is no folder {folder}")
    client = RestClient(gateway or f"http://{said.host}:{said.port}", token or _secret(said), "see its log")
    here = Viewpoint(
        file=str(file),
        settings=said,
        client=client,
        url=client.url,
        has_token=client.has_token,
        certificates=certificates,
        mappings=mappings,
        wall_s=time.time,
        ntp=ntp_synchronised,
        free_bytes=free_on,
    )

    found = asyncio.run(findings(plant, here))
    for line in lines(found):
        typer.echo(line)
    counts = {verdict: sum(each.verdict is verdict for each in found) for verdict in Verdict}
    lacking, dark = counts[Verdict.MISSING], counts[Verdict.UNKNOWN]
    typer.echo(f"{lacking} missing, {dark} unknown, {counts[Verdict.OK]} ok")
    if json is not None:
        write_json(json, {"plant": plant.id, "missing": lacking, "unknown": dark, "findings": found})
    if lacking:
        raise typer.Exit(1)


def _secret(settings: Settings) -> str | None:
    return None if settings.admin_token is None else settings.admin_token.get_secret_value()
