"""The work of `dray up`: a simulated factory in its own thread, and the gateway on this one.

The start follows the likelihood of failure: the port, the database, the factory. Everything is closed in the opposite order, after
any error.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Callable, Coroutine, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from fastapi import FastAPI
from opentelemetry.sdk.trace import TracerProvider

from dray.adapters.documents import FetchedDocuments
from dray.adapters.security.signing import SigningKey
from dray.adapters.vda5050.link import BrokerAddress
from dray.cli.runtime.gateway.authority import authority_of
from dray.cli.runtime.gateway.first_users import welcome
from dray.cli.runtime.gateway.operators import OperatorWorkers
from dray.cli.runtime.gateway.service import (
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
from dray.cli.runtime.telemetry.logs import prepare_logs
from dray.cli.runtime.telemetry.traces import traced, watched
from dray.cli.simulation.factory_meter import FactoryMeter
from dray.cli.simulation.fault_injection import SimFaultInjector
from dray.cli.simulation.rehearsal import Rehearsed, rehearsing
from dray.cli.simulation.scenario_player import SimScenarioPlayer
from dray.gateway.app import create_app
from dray.gateway.live.timescale import TimeScale
from dray.messages.keys import Keys
from dray.ports import Bus
from dray.store import Store, open_store
from dray_sim.bodies.floor import NEARLY_EMPTY_FRAC
from dray_sim.clock.loop import VirtualClock, paced, virtual_loop
from dray_sim.clock.wall import HurryingClock, Wall
from dray_sim.factory.installation import directly
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Faults
from dray_sim.network.bridge import BridgedBus, SimThread
from dray_sim.people.porters import Porters
from dray_sim.run.live import LivePlay
from dray_sim.run.stage import with_right_of_way
from dray_sim.scenarios import LivePart
from dray_sim.vda5050.broker_fleet import BrokerFleet

if TYPE_CHECKING:
    # They need an extra.
    from dray_sim.controllers.opcua_bodies import OpcUaBodies
    from dray_sim.controllers.opcua_server import ControllerServer

BUILDING_S = 60.0
"""Longest wait for the factory to be built: one of 1,000 vehicles takes some seconds."""


@dataclass(frozen=True, slots=True)
class Inside:
    """The interface of a built factory to the outside.

    Attributes:
        factory: for its own thread only, except for reading its counts.
        faults: for the factory's thread only.
        time: the factory's clock and ours.
        play: the scenario in it, for the factory's thread only; None without a script.
    """

    factory: SimFactory
    faults: Faults
    time: TimeScale
    play: LivePlay | None = None


Factory = SimThread[Inside]


async def run_service(
    service: Service,
    seed: int,
    broker: BrokerAddress | None = None,
    live: LivePart | None = None,
    wall: Wall | None = None,
    controllers: ControllerServer | None = None,
) -> None:
    """Run until a signal.

    Args:
        service: the parameters of the service.
        seed: determines all randomness in the factory.
        broker: the broker of vehicles that speak VDA 5050; None for none.
        live: the scenario to play, whose plant is the service's; None for a factory without a script.
        wall: the clock of factory and gateway; the computer's when None.
        controllers: the OPC UA server of the controllers of machines, storages and gate; None for ones without controllers.

    Raises:
        UnavailableError: the port or the database is unavailable.
        Exception: any that ended the factory.
    """
    wall = wall or HurryingClock().wall
    service, token = with_admin_token(service)
    settings = service.settings
    prepare_logs(settings)
    with contextlib.ExitStack() as stack:
        listener = stack.enter_context(contextlib.closing(listen(settings.host, settings.port)))
        port = listener.getsockname()[1]
        stops = stack.enter_context(contextlib.closing(listen_for_stops(settings, port)))
        service = with_stop_port(service, stops)
        store = await open_store(settings.database_url)
        try:
            # The floor is new, and no agent of it has a journal.
            incarnation = await store.begin_anew(service.plant.id, wall.now_s())
            authority = await authority_of(store)
            tracing = stack.enter_context(traced(settings))
            life = _life(service, seed, incarnation, authority, tracing, broker, controllers, live, wall)
            factory = SimThread(life, paced(service.speed), wall=wall)
            try:
                inside = await asyncio.to_thread(factory.start, BUILDING_S)
                player = _player(factory, inside, live, wall)
                app = _app(
                    service, store, authority, factory, inside, incarnation, (stops, port), player, wall
                )
                url = address_of(listener, settings.host)
                await note_address(service, store, url, wall.now_s())
                greeting = greeting_of(
                    service, url, token, await welcome(store, service.plant.file, wall.now_s())
                )
                async with contextlib.AsyncExitStack() as beside:
                    if player is not None and live is not None:
                        rehearsed = Rehearsed(live.part.name, seed, settings.traffic)
                        await beside.enter_async_context(rehearsing(rehearsed, player.expect))
                    await serve(service, app, listener, greeting, factory.wait)
            finally:
                await asyncio.to_thread(factory.stop)
        finally:
            await store.close()


def _life(
    service: Service,
    seed: int,
    incarnation: int,
    authority: SigningKey,
    tracing: TracerProvider | None,
    broker: BrokerAddress | None,
    controllers: ControllerServer | None,
    live_part: LivePart | None,
    wall: Wall,
) -> Callable[[Callable[[Inside], None]], Coroutine[None, None, None]]:
    """The main function of the factory's thread."""

    async def live(ready: Callable[[Inside], None]) -> None:
        loop = virtual_loop()
        now = loop.clock

        def to_wall_s(plant_s: float) -> float:
            """Convert by the clocks' offset, taken when the factory was built; no agent speaks earlier."""
            return scale.to_wall_s(plant_s)

        documents = FetchedDocuments()
        fleet = None if broker is None else BrokerFleet(service.plant, now, broker, to_wall_s)
        bodies = None if controllers is None else _bodies(service, controllers, now, documents)
        make = partial(
            SimFactory,
            incarnation=incarnation,
            authority=authority,
            meet=watched(service.settings, tracing, to_wall_s),
        )
        play = None
        if live_part is None:
            factory = make(
                service.plant,
                now,
                seed=seed,
                stock_frac=NEARLY_EMPTY_FRAC,
                strategists=service.settings.strategists,
                traffic=service.settings.traffic,
                embody=directly if fleet is None else fleet.embody,
                bodies=bodies,
            )
            faults = Faults(factory)
        else:
            with with_right_of_way(service.settings.traffic):
                play = LivePlay(live_part.part, service.plant, seed, make)
            factory, faults = play.stage.factory, play.stage.faults
        if factory.traffic is not None:
            # Otherwise there are no held places that people would have to free.
            Porters(factory, faults)
        loop.begin()
        scale = TimeScale(now.now_s(), wall.now_s(), service.speed)
        if wall.stands:
            loop.stood = scale.stood
        for workcell in factory.workcells.values():
            workcell.documents = documents
        try:
            if fleet is not None:
                await fleet.ready()
            if bodies is not None:
                await bodies.ready()
            ready(Inside(factory, faults, scale, play))
            await (factory.run() if play is None else play.run())
        finally:
            documents.close()
            if bodies is not None:
                bodies.end()
            if fleet is not None:
                await fleet.end()

    return live


def _bodies(
    service: Service, controllers: ControllerServer, now: VirtualClock, documents: FetchedDocuments
) -> OpcUaBodies:
    """The controllers of the factory's machines, storages and gate, created on its loop."""
    from dray_sim.controllers.opcua_bodies import OpcUaBodies

    return OpcUaBodies(service.plant, now, controllers, service.speed, documents)


def _app(
    service: Service,
    store: Store,
    authority: SigningKey,
    factory: Factory,
    inside: Inside,
    incarnation: int,
    stops: tuple[socket.socket, int],
    player: SimScenarioPlayer | None,
    wall: Wall,
) -> FastAPI:
    settings, plant = service.settings, service.plant

    @contextlib.contextmanager
    def beside() -> Iterator[Bus]:
        yield BridgedBus(inside.factory.bus, factory.loop, asyncio.get_running_loop())

    bus = BridgedBus(inside.factory.bus, factory.loop, asyncio.get_running_loop())
    wall.met(factory.loop, bus.outbound)
    historian = historian_of(settings, plant, store, bus, inside.time, incarnation, wall.now_s)
    return create_app(
        settings=settings,
        plant=plant.file,
        bus=bus,
        store=store,
        time=inside.time,
        authority=authority,
        incarnation=incarnation,
        wall_s=wall.now_s,
        historian=historian,
        collectors=(FactoryMeter(inside.factory, bus),),
        faults=SimFaultInjector(inside.faults, factory.loop, wall.now_s),
        beside=StopPath(*stops, settings, beside, authority, inside.time, incarnation, wall.now_s).beside,
        operators=OperatorWorkers(bus, Keys(plant.id), inside.time, wall.now_s),
        scenario=player,
    )


def _player(factory: Factory, inside: Inside, live: LivePart | None, wall: Wall) -> SimScenarioPlayer | None:
    """The player of the scenario; None without one."""
    if inside.play is None or live is None:
        return None
    return SimScenarioPlayer(inside.play, factory.loop, live.shows, inside.time, wall.hurry)
