"""`dray floor`: the simulated bodies of a plant whose agents are processes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dray.cli.runtime.options import SettingsFile, Traffic


def floor(
    settings: SettingsFile = None,
    seed: Annotated[int, typer.Option(help="Seed of how full buffers are at the start.")] = 1,
    traffic: Traffic = None,
    foreign: Annotated[
        str | None,
        typer.Option(
            help="Vehicles that speak VDA 5050, as ATV1,ATV2: places count what these say they pick and drop; else DRAY_FOREIGN.",
        ),
    ] = None,
    opcua: Annotated[
        Path | None,
        typer.Option(
            help="Machines, storages and the gate are behind an OPC UA server on this computer; the mapping file of each is written into this folder.",
        ),
    ] = None,
    vda5050: Annotated[
        bool,
        typer.Option("--vda5050", help="All vehicles speak VDA 5050, at the broker of DRAY_BROKER."),
    ] = False,
    open_gate: Annotated[
        bool,
        typer.Option("--open-gate", help="The gate lets everything in: people are the body of its agent."),
    ] = False,
) -> None:
    """Run the simulated floor: the bodies of all vehicles and machines, for agents that have none of their own."""
    import asyncio

    from dray.cli.runtime.bodies.broker import broker_of
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.surroundings import Surroundings
    from dray.cli.simulation.floor_process import serve_floor

    loaded = load_settings(settings_file=settings, traffic=traffic, foreign=foreign)
    where = Surroundings.of(loaded)
    broker = broker_of(loaded) if vda5050 else None
    if opcua is None:
        asyncio.run(serve_floor(where, seed, vda5050=broker, open_gate=open_gate))
        return

    from dray_sim.controllers.local_server import local_server

    with local_server(
        where.plant.machines, opcua, where.plant.stores.values(), gate=not open_gate
    ) as controllers:
        asyncio.run(serve_floor(where, seed, controllers, vda5050=broker, open_gate=open_gate))
