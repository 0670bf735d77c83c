"""`dray fleet`: commands that start a factory of processes, show it, update it, and kill parts of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from dray.cli.runtime.options import Strategists, Traffic, number

app = typer.Typer(no_args_is_help=True, help="A whole factory as processes on this computer.")

Folder = Annotated[
    Path, typer.Option("--folder", help="Where journals, certificates, logs and the database are.")
]
DEFAULT_FOLDER = Path("fleet")


@app.callback()
def fleet() -> None:
    """A whole factory as processes on this computer."""


@app.command()
def up(
    plant: Annotated[
        Path | None, typer.Option(help="A plant file; else DRAY_PLANT_FILE, else the default plant.")
    ] = None,
    folder: Folder = DEFAULT_FOLDER,
    port: Annotated[
        int | None, typer.Option(min=0, max=65_535, help="Port of the gateway; else DRAY_PORT, else 8000.")
    ] = None,
    db: Annotated[
        str | None,
        typer.Option(help="URL of the database; else DRAY_DATABASE_URL, else a file in the folder."),
    ] = None,
    speed: Annotated[
        float,
        typer.Option(
            parser=number(least=0.1, most=50.0),
            metavar="NUMBER",
            help="Factory seconds per real second, from 0.1 to 50.",
        ),
    ] = 1.0,
    plain: Annotated[
        bool, typer.Option("--plain", help="No certificates: links can be read, and messages forged.")
    ] = False,
    demand: Annotated[bool, typer.Option("--demand/--no-demand", help="Place orders.")] = True,
    metrics: Annotated[
        bool,
        typer.Option(
            "--metrics", help="Each process serves its metrics for Prometheus; metrics.json says where."
        ),
    ] = False,
    opcua: Annotated[
        bool,
        typer.Option(
            "--opcua",
            help="Machines, storages and the gate are behind an OPC UA server of the floor; their mapping files are in the folder, in controllers.",
        ),
    ] = False,
    vda5050: Annotated[
        str, typer.Option(help="Vehicles speak VDA 5050 at this broker: mqtt://HOST:1883.", metavar="BROKER")
    ] = "",
    people_at_gate: Annotated[
        bool,
        typer.Option(
            "--people-at-gate", help="People say what has arrived at the gate, on the tablet or over REST."
        ),
    ] = False,
    strategists: Strategists = None,
    traffic: Traffic = None,
) -> None:
    """Start every agent of a plant as a process; ended ones are started again. Ctrl-C stops all."""
    if not math.isfinite(speed):
        raise typer.BadParameter("must be a number", param_hint="--speed")

    import asyncio
    from functools import partial
    from importlib.util import find_spec

    if opcua and find_spec("asyncua") is None:
        reason = "OPC UA needs more than is installed: pip install 'dray[opcua]'"
        raise typer.BadParameter(reason, param_hint="--opcua")

    from dray.cli.commands.plant import chosen_plant
    from dray.cli.fleet.supervisor import FleetOptions, run_fleet
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.plant_errors import tell_errors

    load = partial(load_settings, port=port, plant_file=plant, strategists=strategists, traffic=traffic)
    settings = load(database_url=db)
    if "database_url" not in settings.model_fields_set:
        settings = load(database_url=f"sqlite:///{folder.resolve() / 'dray.db'}")
    chosen = chosen_plant(settings.plant_file)
    tell_errors(chosen, traffic=settings.traffic)
    asyncio.run(
        run_fleet(
            FleetOptions(
                settings,
                chosen,
                folder,
                speed=speed,
                plain=plain,
                demand=demand,
                metrics=metrics,
                opcua=opcua,
                vda5050=vda5050,
                people_at_gate=people_at_gate,
            )
        )
    )


@app.command()
def update(
    python: Annotated[
        Path,
        typer.Option(
            "--python", help="The Python of the other version's environment, as /opt/dray-2/bin/python."
        ),
    ],
    only: Annotated[
        list[str] | None,
        typer.Option("--only", help="Replace this process alone, as ATV3; may be repeated. Else all."),
    ] = None,
    canary_tasks: Annotated[
        int, typer.Option(min=1, max=100, help="Tasks that each agent has to do well.")
    ] = 3,
    patience: Annotated[
        float,
        typer.Option(
            parser=number(least=1.0),
            metavar="SECONDS",
            help="Factory seconds, at least 1, in which there should be work for that.",
        ),
    ] = 1800.0,
    folder: Folder = DEFAULT_FOLDER,
    json: Annotated[Path | None, typer.Option(help="Write the report here too.")] = None,
) -> None:
    """Replace agents one at a time, each a canary; if one fails, all are rolled back. Ctrl-C stops it there."""
    import asyncio

    from dray.cli.fleet.rollout.report import show
    from dray.cli.fleet.rollout.update import Plan, update_fleet
    from dray.cli.fleet.software import ask
    from dray.cli.runtime.output import write_json

    plan = Plan(folder, ask(python), tuple(only or ()), canary_tasks, patience)
    report = asyncio.run(update_fleet(plan, lambda line: typer.echo(line, err=True)))
    show(report)
    typer.echo(f"{report.version}: {report.end}")
    if json is not None:
        write_json(json, report)
    if not report.done:
        raise typer.Exit(1)


@app.command()
def down(folder: Folder = DEFAULT_FOLDER) -> None:
    """End a fleet, including the processes of a killed `dray fleet up`."""
    import asyncio

    from dray.cli.fleet.ending import end_fleet

    typer.echo(f"{asyncio.run(end_fleet(folder))} processes ended")


@app.command()
def status(folder: Folder = DEFAULT_FOLDER) -> None:
    """Show the processes: which run, which are on the bus, how often each was started, and its version."""
    import asyncio

    from dray.cli.fleet.process_registry import present_agents, read_registry
    from dray.cli.runtime.output import table

    registry = read_registry(folder)
    present = asyncio.run(present_agents(registry, folder))
    table(
        ("process", "pid", "runs", "on the bus", "starts", "version", ""),
        [
            (
                member.name,
                str(member.pid),
                "yes" if member.runs else "no",
                ("yes" if member.name in present else "no") if member.joins else "",
                str(member.starts),
                member.software.version,
                member.state,
            )
            for member in registry.members
        ],
    )


@app.command()
def kill(
    name: Annotated[str, typer.Argument(help="The process, as ATV3.")],
    away: Annotated[
        float | None,
        typer.Option(
            parser=number(least=1.0),
            help="Seconds until it is started again, at least 1; without it, it is started again at once.",
            metavar="SECONDS",
        ),
    ] = None,
    folder: Folder = DEFAULT_FOLDER,
) -> None:
    """Kill a process as a power failure does; `dray fleet up` starts it again."""
    import asyncio
    import signal

    from dray.cli.fleet import control
    from dray.cli.fleet.process_registry import read_registry
    from dray.cli.runtime.output import one_of
    from dray.errors import UnavailableError

    member = one_of({member.name: member for member in read_registry(folder).members}, name, "NAME")
    killed = member.signal(signal.SIGKILL) if away is None else asyncio.run(control.kill(folder, name, away))
    if not killed:
        raise UnavailableError(name, "does not run", "wait until `dray fleet up` has started it")
    typer.echo(f"{name}: killed process {member.pid}")
