"""The gateway and the historian as processes of their own."""

from __future__ import annotations

import asyncio
import contextlib
import time

from dray.adapters.system_clock import SystemClock
from dray.cli.runtime.gateway.authority import authority_of
from dray.cli.runtime.gateway.first_users import welcome
from dray.cli.runtime.gateway.operators import OperatorWorkers
from dray.cli.runtime.gateway.service import (
    Customers,
    Service,
    greeting_of,
    historian_of,
    note_address,
    serve,
    with_admin_token,
    with_stop_port,
)
from dray.cli.runtime.gateway.stop_path import StopPath, listen_for_stops
from dray.cli.runtime.listener import address_of, listen
from dray.cli.runtime.readiness import say_ready
from dray.cli.runtime.signals import stopped_by_signals
from dray.cli.runtime.surroundings import Surroundings
from dray.cli.runtime.telemetry.bus_meter import BusMeter
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.errors import UnavailableError
from dray.gateway.app import create_app
from dray.gateway.metrics.history import History
from dray.messages import OPERATOR_PREFIX
from dray.messages.keys import HISTORIAN, Keys
from dray.store import open_store


async def run_gateway(where: Surroundings, customers: Customers | None = None) -> None:
    """Run a gateway until a signal.

    Args:
        where: the process's surroundings.
        customers: simulated customers; None for none.

    Raises:
        UnavailableError: the port, the bus or the database is unavailable, or another gateway has taken its
            name.
    """
    plant = where.plant
    elsewhere = asyncio.Event()
    operators: OperatorWorkers | None = None

    def give_way(agent: str) -> None:
        if operators is not None and agent.startswith(OPERATOR_PREFIX):
            operators.give_way(agent)
        else:
            elsewhere.set()

    service, token = with_admin_token(
        Service(where.settings, plant, speed=where.settings.plant_speed, customers=customers)
    )
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(
            contextlib.closing(listen(service.settings.host, service.settings.port))
        )
        port = listener.getsockname()[1]
        stops = stack.enter_context(contextlib.closing(listen_for_stops(service.settings, port)))
        service = with_stop_port(service, stops)
        settings = service.settings
        store = await open_store(settings.database_url)
        try:
            async with where.bus(settings.gateway_name, give_way) as bus:
                authority = await authority_of(store)
                incarnation = await store.next_incarnation(plant.id)
                # Steered like the agents' clocks: if the computer's clock is set, no agent appears silent.
                wall = SystemClock(asyncio.get_running_loop())
                operators = OperatorWorkers(bus, Keys(plant.id), where.time, wall.now_s)
                app = create_app(
                    settings=settings,
                    plant=plant.file,
                    bus=bus,
                    store=store,
                    time=where.time,
                    authority=authority,
                    incarnation=incarnation,
                    collectors=(BusMeter(bus), ClockMeter(wall)),
                    wall_s=wall.now_s,
                    beside=StopPath(
                        stops, port, settings, bus.beside, authority, where.time, incarnation
                    ).beside,
                    operators=operators,
                )
                url = address_of(listener, settings.host)
                await note_address(service, store, url, time.time())
                links = await welcome(store, plant.file, time.time())
                async with operators.running():
                    greeting = greeting_of(service, url, token, links)
                    await serve(service, app, listener, greeting, elsewhere.wait)
        finally:
            await store.close()
    if elsewhere.is_set():
        remedy = "give every gateway of a plant its own --name"
        raise UnavailableError(settings.gateway_name, "has been started elsewhere", remedy)


async def run_historian(where: Surroundings) -> None:
    """Run the historian until a signal.

    Raises:
        UnavailableError: the bus or the database is unavailable, or a historian has been started elsewhere.
    """
    stopped = asyncio.Event()
    elsewhere = False

    def give_way(_agent: str) -> None:
        nonlocal elsewhere
        elsewhere = True
        stopped.set()

    store = await open_store(where.settings.database_url)
    try:
        async with where.bus(HISTORIAN, give_way) as bus:
            life = await store.next_incarnation(where.plant.id)
            # Steered like the gateway's: if the computer's clock is set ahead, young data is not deleted as too old.
            wall = SystemClock(asyncio.get_running_loop())
            historian = historian_of(where.settings, where.plant, store, bus, where.time, life, wall.now_s)
            async with where.told(BusMeter(bus), History(historian)):
                with stopped_by_signals(stopped.set):
                    async with historian.running():
                        say_ready(HISTORIAN)
                        await stopped.wait()
    finally:
        await store.close()
    if elsewhere:
        raise UnavailableError(HISTORIAN, "has been started elsewhere", "stop one of the two")
