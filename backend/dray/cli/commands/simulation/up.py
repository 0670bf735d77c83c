"""`dray up`: the simulated factory, the gateway and the panels in one process."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from dray.cli.runtime.options import Traffic


def up(
    host: Annotated[
        str | None,
        typer.Option(help="Address to serve on; else DRAY_HOST, else 127.0.0.1: this machine only."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65_535, help="Port; 0 for any free one; else DRAY_PORT, else 8000."),
    ] = None,
    db: Annotated[
        str | None,
        typer.Option(help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db."),
    ] = None,
    plant: Annotated[
        Path | None,
        typer.Option(
            help="A plant file; else DRAY_PLANT_FILE, else the default plant of 12 machines and 8 vehicles."
        ),
    ] = None,
    speed: Annotated[float, typer.Option(help="Factory seconds per real second.")] = 1.0,
    seed: Annotated[int, typer.Option(help="Everything that is left to chance follows from it.")] = 1,
    demand: Annotated[
        bool, typer.Option("--demand/--no-demand", help="Place orders, so that there is something to see.")
    ] = True,
    traffic: Traffic = False,
) -> None:
    """Run a simulated factory with its panels; Ctrl-C stops it."""
    if not (math.isfinite(speed) and speed > 0):
        raise typer.BadParameter("must be above 0", param_hint="--speed")

    import asyncio

    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.service import Service
    from dray.cli.simulation.customers import customers_of
    from dray.cli.simulation.one_process import run_service

    settings = load_settings(host=host, port=port, database_url=db, plant_file=plant, traffic=traffic or None)
    chosen = chosen_plant(settings.plant_file)
    customers = customers_of(chosen, speed=speed, seed=seed) if demand else None
    asyncio.run(run_service(Service(settings, chosen, speed, customers), seed))
