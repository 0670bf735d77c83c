"""`dray gateway` and `dray historian`: the parts of `dray up` for agents that are processes."""

from __future__ import annotations

from typing import Annotated

import typer

from dray.cli.runtime.options import SettingsFile

Database = Annotated[
    str | None, typer.Option(help="URL of the database; else DRAY_DATABASE_URL, else sqlite:///dray.db.")
]


def gateway(
    host: Annotated[
        str | None, typer.Option(help="Address to serve on; else DRAY_HOST, else 127.0.0.1.")
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65_535, help="Port; 0 for any free one; else DRAY_PORT, else 8000."),
    ] = None,
    db: Database = None,
    name: Annotated[
        str | None,
        typer.Option(
            help="Its name on the bus, where there are several gateways; else DRAY_GATEWAY_NAME, else gateway."
        ),
    ] = None,
    demand: Annotated[
        bool, typer.Option("--demand/--no-demand", help="Place orders, so that there is something to see.")
    ] = False,
    settings: SettingsFile = None,
) -> None:
    """Run a gateway: panels and API for a plant whose agents run elsewhere."""
    import asyncio

    from dray.cli.runtime.gateway.gateway_process import run_gateway
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.surroundings import Surroundings

    where = Surroundings.of(load_settings(settings, host=host, port=port, database_url=db, gateway_name=name))
    customers = None
    if demand:
        from dray.cli.simulation.customers import customers_of

        customers = customers_of(where.plant, speed=where.settings.plant_speed, seed=1)
    asyncio.run(run_gateway(where, customers))


def historian(db: Database = None, settings: SettingsFile = None) -> None:
    """Run the historian, which writes the plant's events to the database; one is enough."""
    import asyncio

    from dray.cli.runtime.gateway.gateway_process import run_historian
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.surroundings import Surroundings

    asyncio.run(run_historian(Surroundings.of(load_settings(settings, database_url=db))))
