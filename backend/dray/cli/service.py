"""What `dray up` runs: a simulated factory in its own thread, and the gateway on this one.

The order of the start is the order of what may fail: the port, the database, the factory. Everything
that was opened is closed in the opposite order, whatever happens.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass

import typer
from sqlalchemy import make_url

from dray import __version__
from dray.cli.serving import Server, address_of, on_signal, open_port
from dray.plant import Plant
from dray.ports import Bus
from dray.settings import Settings
from dray.store import Store, open_store
from dray_sim.bridge import BridgedBus, SimThread
from dray_sim.factory import SimFactory
from dray_sim.loop import clock, paced

FACTORY_START_S = 60.0
"""Longest wait for the factory to be built: one of 1,000 vehicles takes some 5 s."""


@dataclass(frozen=True, slots=True)
class Service:
    """What is to be run.

    Attributes:
        settings: the gateway's.
        plant: the factory's.
        speed: factory seconds per real second.
        seed: of everything that is left to chance.
        demand: place orders too.
    """

    settings: Settings
    plant: Plant
    speed: float
    seed: int
    demand: bool


@dataclass(frozen=True, slots=True)
class Started:
    """What the outside needs of a factory that has been built.

    Attributes:
        bus: inside the factory's thread.
        plant_s: the plant's clock...
        wall_s: ...and the same moment on the wall clock, in seconds since 1970.
    """

    bus: Bus
    plant_s: float
    wall_s: float


async def run_service(service: Service) -> None:
    """Run until a signal.

    Raises:
        UnavailableError: the port, or the database.
        whatever ended the factory.
    """
    settings = service.settings
    with contextlib.closing(open_port(settings.host, settings.port)) as listener:
        store = await open_store(settings.database_url)
        try:
            await _serve(service, store, listener)
        finally:
            await store.close()


async def _serve(service: Service, store: Store, listener: socket.socket) -> None:
    incarnation = await store.next_incarnation(service.plant.id)
    factory = SimThread(_life(service, incarnation), paced(service.speed))
    try:
        started = await asyncio.to_thread(factory.start, FACTORY_START_S)
        raise NotImplementedError(started)
    finally:
        await asyncio.to_thread(factory.stop)
