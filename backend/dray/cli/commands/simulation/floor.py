"""`dray floor`: the simulated bodies of a plant whose agents are processes."""

from __future__ import annotations

from typing import Annotated

import typer

from dray.cli.runtime.options import SettingsFile, Traffic


def floor(
    settings: SettingsFile = None,
    seed: Annotated[int, typer.Option(help="How full buffers are at the start follows from it.")] = 1,
    traffic: Traffic = None,
    foreign: Annotated[
        str | None,
        typer.Option(
            help="Vehicles that speak VDA 5050, as ATV1,ATV2: places count what these say they pick and drop; else DRAY_FOREIGN.",
        ),
    ] = None,
) -> None:
    """Run the simulated floor: the bodies of all vehicles and machines, for agents that have none of their own."""
    import asyncio

    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.surroundings import Surroundings
    from dray.cli.simulation.floor_process import serve_floor

    loaded = load_settings(settings_file=settings, traffic=traffic, foreign=foreign)
    asyncio.run(serve_floor(Surroundings.of(loaded), seed))
