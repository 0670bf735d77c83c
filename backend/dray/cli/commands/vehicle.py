"""`dray vehicle`: commissioning of real vehicles that speak VDA 5050, and their dialogues as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.runtime.options import PanelUrl, SettingsFile

if TYPE_CHECKING:
    from dray.cli.runtime.surroundings import Surroundings

app = typer.Typer(no_args_is_help=True, help="Real vehicles that speak VDA 5050.")

Broker = Annotated[str | None, typer.Option(help="mqtt://HOST:1883, or mqtts:// for TLS; else DRAY_BROKER.")]
Manufacturer = Annotated[
    str | None, typer.Option(help="Its manufacturer, as its topics name it; else DRAY_MANUFACTURER.")
]
Serial = Annotated[
    str | None, typer.Option(help="Its serial number, as its topics name it; else DRAY_SERIAL.")
]
Profile = Annotated[
    str | None, typer.Option(help="What it understands: a file, or one that is shipped; else DRAY_PROFILE.")
]
PlantOption = Annotated[
    Path | None, typer.Option("--plant", help="A plant file; else DRAY_PLANT_FILE, else the default plant.")
]


@app.command()
def check(
    broker: Broker = None,
    manufacturer: Manufacturer = None,
    serial: Serial = None,
    profile: Profile = None,
    plant: PlantOption = None,
    type_: Annotated[
        str | None, typer.Option("--type", help="Its type in the plant file; else the first one there.")
    ] = None,
    drive: Annotated[
        str | None,
        typer.Option(
            help="Let it MOVE: to this neighbouring node, pausing on its way back, and once more with a cancel; - for any."
        ),
    ] = None,
    station: Annotated[
        str, typer.Option(help="Let it pick and drop here; it must stand at this station.")
    ] = "",
    item: Annotated[str, typer.Option(help="What it picks there.")] = "",
    quantity: Annotated[int, typer.Option(min=1, help="Pieces that it picks.")] = 1,
    out: Annotated[Path | None, typer.Option(help="Write the report there, too (Markdown).")] = None,
    record: Annotated[
        Path | None, typer.Option(help="Write the dialogue there, for `dray vehicle replay`.")
    ] = None,
    settings: SettingsFile = None,
) -> None:
    """Commission a vehicle: connection, state, factsheet, position; and, if you let it move, a lane, a pause, a cancel, pick and drop.

    Without --drive and --station it only listens. Exit code 1: a step has failed.
    """
    import asyncio

    from dray.adapters.vda5050.commissioning import Wanted
    from dray.cli.runtime.commission import commission
    from dray.cli.runtime.output import check_writable, one_of, write_text

    if out is not None:
        check_writable(out, "--out")
    where = _surroundings(settings, broker, manufacturer, serial, profile, plant)
    types = where.plant.vehicle_types
    kind = one_of(types, type_, "--type") if type_ is not None else next(iter(types.values()))
    wanted = Wanted(None if drive is None else drive.strip("-"), station, item, quantity)
    done = asyncio.run(commission(where, kind, wanted, record, typer.echo))
    typer.echo("\n" + done.report())
    if out is not None:
        write_text(out, done.report(), "--out")
    if not done.passed:
        raise typer.Exit(1)


@app.command()
def status(
    atv: Annotated[
        str, typer.Argument(help="Its id in the plant, as ATV3; without one, all that were heard.")
    ] = "",
    url: PanelUrl = None,
    token: Annotated[
        str | None,
        typer.Option(
            help="A key with factory:read, or the administrator's token, which `dray up` prints; else DRAY_ADMIN_TOKEN."
        ),
    ] = None,
) -> None:
    """Show vehicles: status, place, battery, problem, and in the last line what each waits for and what would end it."""
    import time

    from dray.cli.runtime.vehicle_status import ask

    for lines in ask(atv, url, token, time.time()):
        typer.echo("\n".join(lines))


@app.command()
def record(
    file: Annotated[
        Path, typer.Argument(help="Where the dialogue is written; one that is there is replaced.")
    ],
    broker: Broker = None,
    manufacturer: Manufacturer = None,
    serial: Serial = None,
    profile: Profile = None,
    plant: PlantOption = None,
    type_: Annotated[str | None, typer.Option("--type", help="Its type in the plant file.")] = None,
    settings: SettingsFile = None,
) -> None:
    """Listen to a vehicle and its master, and write down their messages, until Ctrl-C. Sends nothing itself."""
    import asyncio

    from dray.cli.runtime.commission import listen
    from dray.cli.runtime.output import one_of

    where = _surroundings(settings, broker, manufacturer, serial, profile, plant)
    types = where.plant.vehicle_types
    kind = one_of(types, type_, "--type") if type_ is not None else next(iter(types.values()))
    asyncio.run(listen(where, kind, file, typer.echo))


@app.command()
def replay(
    file: Annotated[Path, typer.Argument(help="A dialogue, as `dray vehicle record` writes it.")],
    plant: PlantOption = None,
    profile: Annotated[
        str | None,
        typer.Option(help="Another profile than that of the dialogue: shows what would differ."),
    ] = None,
    quiet: Annotated[
        bool, typer.Option("--quiet", help="Say only whether the messages are those of the recording.")
    ] = False,
) -> None:
    """Play a dialogue into a fresh driver, and show its reaction. Exit code 1: it differs from the recording."""
    from dray.adapters.vda5050.dialogue import first_difference, read_dialogue
    from dray.adapters.vda5050.dialogue import replay as play
    from dray.adapters.vda5050.profile import load_profile
    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.output import line_text

    head, lines = read_dialogue(file)
    chosen = chosen_plant(plant)
    played = list(play(head, lines, chosen, None if profile is None else load_profile(profile)))
    if not quiet:
        for line in played:
            typer.echo(line_text(line))
    if not any(line.event == "Instructed" for line in lines):
        return  # It was recorded by listening: there are no effects of ours to compare.
    difference = first_difference(lines, played)
    if difference is None:
        typer.echo(f"{sum(bool(line.effect) for line in played)} words of ours, all as recorded")
        return
    for name, word in zip(("recorded", "now     "), difference, strict=True):
        typer.echo(f"{name}: {'nothing more' if word is None else line_text(word)}")
    raise typer.Exit(1)


def _surroundings(
    file: Path | None,
    broker: str | None,
    manufacturer: str | None,
    serial: str | None,
    profile: str | None,
    plant: Path | None,
) -> Surroundings:
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.surroundings import Surroundings

    return Surroundings.of(
        load_settings(
            settings_file=file,
            broker=broker,
            manufacturer=manufacturer,
            serial=serial,
            profile=profile,
            plant_file=plant,
        )
    )
