"""`dray machine`: commissioning of machines with real controllers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dray.cli.runtime.options import SettingsFile

app = typer.Typer(no_args_is_help=True, help="Real machines.")


@app.callback()
def machine() -> None:
    """Real machines."""


@app.command()
def check(
    name: Annotated[
        str,
        typer.Argument(help="Its id in the plant, as M8; or a storage's or a warehouse's, as S3; or gate."),
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(
            "--mapping",
            help="The file that says which nodes or topics of its controller are which signals; else DRAY_MAPPING.",
        ),
    ] = None,
    broker: Annotated[
        str | None,
        typer.Option(help="Where its topics are: mqtt://HOST:1883, or mqtts:// for TLS; else DRAY_BROKER."),
    ] = None,
    plant: Annotated[
        Path | None,
        typer.Option("--plant", help="A plant file; else DRAY_PLANT_FILE, else the default plant."),
    ] = None,
    cycle: Annotated[bool, typer.Option("--cycle", help="Let it WORK: it makes one piece.")] = False,
    dock: Annotated[
        bool,
        typer.Option(
            "--dock",
            help="Let it open its dock, as for a vehicle, or let a container in at the gate; nobody may stand there.",
        ),
    ] = False,
    out: Annotated[Path | None, typer.Option(help="Write the report there, too (Markdown).")] = None,
    settings: SettingsFile = None,
) -> None:
    """Commission the controller of a machine, of a storage's dock or of the gate: connection, each signal and its type; and, if you let it work, one piece and its dock.

    Without --cycle and --dock it only reads. Exit code 1: a step has failed.
    """
    import asyncio

    from dray.cli.runtime.commission import commission_machine
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.output import check_writable, write_text
    from dray.cli.runtime.surroundings import Surroundings

    if out is not None:
        check_writable(out, "--out")
    said = load_settings(settings_file=settings, mapping=mapping, broker=broker, plant_file=plant)
    done = asyncio.run(
        commission_machine(Surroundings.of(said), name, cycle=cycle, dock=dock, say=typer.echo)
    )
    typer.echo("\n" + done.report())
    if out is not None:
        write_text(out, done.report(), "--out")
    if not done.steps.passed:
        raise typer.Exit(1)
