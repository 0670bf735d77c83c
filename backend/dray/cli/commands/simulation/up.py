"""`dray up`: the simulated factory, the gateway and the panels in one process."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.runtime.options import Strategists, Traffic, number

if TYPE_CHECKING:
    from dray.adapters.vda5050.link import BrokerAddress
    from dray.plant import Plant
    from dray_sim.controllers.opcua_server import ControllerServer
    from dray_sim.scenarios import LivePart

SCENARIO_DATABASE = "sqlite:///dray-scenario.db"
"""The scenarios' own database: the orders of another plant in `dray.db` do not belong there."""


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
    speed: Annotated[
        float,
        typer.Option(
            parser=number(above=True), metavar="NUMBER", help="Factory seconds per real second, above 0."
        ),
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of everything that is left to chance.")] = 1,
    demand: Annotated[
        bool, typer.Option("--demand/--no-demand", help="Place orders, so that there is something to see.")
    ] = True,
    scenario: Annotated[
        str | None,
        typer.Option(
            help="Play one of the paper's cases or experiments, as `dray sim list` names them, in its own plant and with "
            "its own orders; without --db or DRAY_DATABASE_URL on dray-scenario.db.",
            show_default=False,
        ),
    ] = None,
    strategists: Strategists = None,
    traffic: Traffic = None,
    vda5050: Annotated[
        bool,
        typer.Option(
            "--vda5050", help="Vehicles speak VDA 5050 (2.0, 2.1 and 3.0 by turns) over an MQTT broker."
        ),
    ] = False,
    real_bodies: Annotated[
        bool,
        typer.Option(
            "--real-bodies",
            help="Machines, storages, source warehouses and the gate are behind an OPC UA server, and vehicles speak VDA 5050 as with --vda5050.",
        ),
    ] = False,
    broker: Annotated[
        str | None,
        typer.Option(
            help="With --vda5050 or --real-bodies: mqtt://HOST:PORT; else one that is started on this machine."
        ),
    ] = None,
) -> None:
    """Run a simulated factory with its panels; Ctrl-C stops it."""
    import asyncio

    from dray.cli.commands.plant import chosen_plant
    from dray.cli.runtime.gateway.service import Service
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.plant_errors import tell_errors
    from dray.cli.simulation.customers import customers_of
    from dray.cli.simulation.one_process import run_service

    settings = load_settings(
        host=host, port=port, database_url=db, plant_file=plant, strategists=strategists, traffic=traffic
    )
    live = None
    if scenario is None:
        chosen = chosen_plant(settings.plant_file)
        tell_errors(chosen, traffic=settings.traffic)
    else:
        live = _live_part(
            scenario,
            {
                "--plant": plant is not None,
                "--strategists": strategists is not None,
                "--vda5050": vda5050,
                "--real-bodies": real_bodies,
            },
        )
        chosen = live.part.plant()
        if "database_url" not in settings.model_fields_set:
            settings = load_settings(host=host, port=port, database_url=SCENARIO_DATABASE, traffic=traffic)
        settings = settings.model_copy(update={"strategists": live.part.shift.strategists or 1})
    customers = customers_of(chosen, speed=speed, seed=seed) if demand and live is None else None
    service = Service(settings, chosen, speed, customers)
    with (
        brokered(vda5050=vda5050 or real_bodies, url=broker) as address,
        controlled(chosen, real_bodies=real_bodies) as controllers,
    ):
        asyncio.run(run_service(service, seed, address, live, controllers=controllers))


def _live_part(name: str, others: Mapping[str, bool]) -> LivePart:
    """The scenario of this name.

    Args:
        name: as `dray sim list` names it.
        others: options that exclude a scenario, and whether they were given.

    Raises:
        BadParameter: one of them was given.
        SettingsError: no scenario of this name can be followed live; lists those that can.
    """
    from dray.cli.runtime.output import one_of
    from dray_sim.scenarios import LIVE

    for option, given in others.items():
        if given:
            raise typer.BadParameter(
                "a scenario has its own plant and its own agents; leave it out", param_hint=option
            )
    return one_of(LIVE, name, "--scenario")


@contextmanager
def brokered(*, vda5050: bool, url: str | None) -> Iterator[BrokerAddress | None]:
    """The broker of vehicles that speak VDA 5050, as long as the context lasts; None without them.

    Raises:
        BadParameter: the address is invalid, or no vehicle speaks VDA 5050.
        UnavailableError: no broker can be started here.
    """
    if not vda5050:
        if url is not None:
            raise typer.BadParameter("only with --vda5050 or --real-bodies", param_hint="--broker")
        yield None
        return

    from dray.adapters.vda5050.link import BrokerAddress, read_address
    from dray_sim.vda5050.local_broker import local_broker

    if url is None:
        with local_broker() as address:
            typer.echo(
                f"MQTT broker        {address}, manufacturer Dray, serial numbers are the vehicles' ids",
                err=True,
            )
            yield address
    else:
        try:
            host, port, tls = read_address(url)
        except ValueError as error:
            raise typer.BadParameter(str(error), param_hint="--broker") from None
        yield BrokerAddress(host, port, tls)


@contextmanager
def controlled(plant: Plant, *, real_bodies: bool) -> Iterator[ControllerServer | None]:
    """The OPC UA server of machines, storages and the gate with controllers, as long as the context lasts; None without them.

    Raises:
        UnavailableError: no server can be started here.
    """
    if not real_bodies:
        yield None
        return

    from tempfile import TemporaryDirectory

    from dray_sim.controllers.local_server import local_server

    with (
        TemporaryDirectory(prefix="dray-mappings-") as folder,
        local_server(plant.machines, Path(folder), plant.stores.values(), gate=True) as server,
    ):
        typer.echo(
            f"OPC UA server      {server.url}, nodes as ns=2;s=MACHINE.pieces\n"
            f"Mapping files      {folder}, one for each machine, storage and source warehouse, and the gate",
            err=True,
        )
        yield server
