"""The `dray` command: the composition root. Only here are concrete classes chosen.

    dray up             the simulated factory, the gateway and the panels in one process
    dray fleet ...      a whole factory as processes on this computer
    dray agent ...      one agent of a plant, as a process of its own
    dray strategist     the strategist, as a process of its own
    dray gateway        panels and API for a plant whose agents are processes
    dray historian      writes the plant's events to the database
    dray floor          the simulated floor, for agents without bodies of their own
    dray sim ...        named scenarios in virtual time
    dray fault ...      inject faults into a running `dray up`
    dray bench          benchmarks
    dray shut-out       exclude an agent; `dray readmit` ends that
    dray carried-away   report that a vehicle is off the floor: its places become free; or list what came of it
    dray user ...       people and their logins
    dray key ...        API keys of other systems
    dray link ...       customers' links to their orders
    dray plant ...      plant files
    dray machine ...    real machines: commissioning
    dray vehicle ...    real vehicles: commissioning, dialogues
    dray certs ...      certificates for agents on many computers
    dray wire ...       the agents' messages, as schemas
    dray db ...         the database

`commands` has one module per group, with Typer only. `runtime` contains the parts of a process in service. `fleet` supervises many
processes, `compose` writes them as containers, and `simulation` runs simulated parts: beside its commands it is the only room that
imports `dray_sim`. Each command imports its modules when it runs, so that `dray --help` answers at once. Results are printed on stdout,
everything else on stderr.

Exit codes: 0 done; 1 a broken invariant, or something outside is unavailable; 2 unusable input.
"""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from dray import __version__
from dray.cli.commands import agent, gateway, machine, plant, vehicle, wire
from dray.cli.commands.administration import carried_away, certs, db, key, link, shut_out, user
from dray.cli.commands.compose import compose
from dray.cli.commands.fleet import app as fleet_app
from dray.cli.commands.simulation import bench, fault, floor, sim, up
from dray.errors import DrayError, InputError

app = typer.Typer(
    name="dray",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("up")(up.up)
app.add_typer(fleet_app, name="fleet")
app.command("compose")(compose)
app.add_typer(agent.app, name="agent")
app.command("strategist")(agent.strategist)
app.command("floor")(floor.floor)
app.command("gateway")(gateway.gateway)
app.command("historian")(gateway.historian)
app.command("bench")(bench.bench)
app.add_typer(sim.app, name="sim")
app.add_typer(fault.app, name="fault")
app.command("shut-out")(shut_out.shut_out)
app.command("readmit")(shut_out.readmit)
app.command("carried-away")(carried_away.carried_away)
app.add_typer(user.app, name="user")
app.add_typer(key.app, name="key")
app.add_typer(link.app, name="link")
app.add_typer(plant.app, name="plant")
app.add_typer(certs.app, name="certs")
app.add_typer(machine.app, name="machine")
app.add_typer(vehicle.app, name="vehicle")
app.add_typer(wire.app, name="wire")
app.add_typer(db.app, name="db")


def show_version(wanted: bool) -> None:
    """Print the version and leave."""
    if wanted:
        from dray.messages.base import WIRE_VERSION

        typer.echo(f"dray {__version__}, wire version {WIRE_VERSION}")
        raise typer.Exit


@app.callback()
def dray(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Material flow of a factory with no dispatcher: machines hire the vehicles that feed them."""


def main() -> None:
    """Run the command line; our own errors become one clear line on stderr and an exit code."""
    try:
        app()
    except DrayError as error:
        typer.echo(f"dray: {error}", err=True)
        sys.exit(2 if isinstance(error, InputError) else 1)
