"""The services of one running gateway: making, restoring from SQL, and running them.

Only this module wires them: every service gets what it uses.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any

import msgspec
from prometheus_client.registry import Collector

from dray.adapters.security.signing import SigningKey
from dray.errors import UnavailableError
from dray.gateway.access.access import Access, open_access
from dray.gateway.access.audit_log import AuditLog
from dray.gateway.access.login.hasher import Hasher
from dray.gateway.factory.alerts import AlertMonitor
from dray.gateway.factory.area_pause import AreaPause
from dray.gateway.factory.carrying import Carrying
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.factory.closings import Closings
from dray.gateway.factory.commands import Commands
from dray.gateway.factory.duty import DutyRota, OperatorHost
from dray.gateway.factory.dxf_plans import DxfPlans
from dray.gateway.factory.estimate_keeper import EstimateKeeper
from dray.gateway.factory.exclusions import Exclusions
from dray.gateway.factory.fault_injection import FaultInjection, FaultInjector
from dray.gateway.factory.figure_sampler import Sampler
from dray.gateway.factory.plant_drafts import as_yaml
from dray.gateway.factory.promises import Ledger
from dray.gateway.factory.scenario_play import ScenarioPlay, ScenarioPlayer
from dray.gateway.factory.shift_player import ShiftPlayer
from dray.gateway.factory.shift_reporter import ShiftReporter
from dray.gateway.http.assets import Panels
from dray.gateway.http.renderings import Renderings
from dray.gateway.http.side_work import SideWork
from dray.gateway.inbox import Inbox
from dray.gateway.live.backfill import backfill_news
from dray.gateway.live.database_sync import DatabaseSync
from dray.gateway.live.health import Health
from dray.gateway.live.joinings import Joinings
from dray.gateway.live.peer import Peer
from dray.gateway.live.projection import Projection
from dray.gateway.live.replay.reader import ReplayReader
from dray.gateway.live.replay.recorder import DAY_S, Recorder
from dray.gateway.live.strategist_probe import StrategistProbe
from dray.gateway.live.stream import Hub
from dray.gateway.live.timescale import TimeScale
from dray.gateway.metrics import Metrics
from dray.gateway.metrics.history import History
from dray.gateway.metrics.state import State
from dray.gateway.orders.actions import OrderActions
from dray.gateway.orders.change_feed import ChangeFeed
from dray.gateway.orders.changes import OrderChanging
from dray.gateway.orders.completions import Completions
from dray.gateway.orders.idempotency import KEYS_KEPT_S
from dray.gateway.orders.outbox import Outbox
from dray.gateway.orders.placement import OrderPlacement
from dray.gateway.orders.reconciliation import Reconciliation
from dray.gateway.orders.transports import PlainTransports
from dray.gateway.schedules.runs import Runs
from dray.gateway.schedules.scheduler import Scheduler
from dray.messages.keys import Keys, strategists_of
from dray.plant.model import PlantFile
from dray.ports import Bus
from dray.settings import Settings
from dray.store import Historian, Store
from dray.store.orders.placing import Placing
from dray.supervision import Supervisor

Beside = Callable[[Commands, Access], AbstractAsyncContextManager[None]]
"""A context that runs with the gateway: the stop path."""

PLAYER = "shift player"
"""Caller of side work that no client waits for."""


@dataclass(frozen=True)
class Services:
    """All services. Only `app` and this file know this type: see `http.provided`."""

    settings: Settings
    plant: PlantFile
    """The file at the gateway's start; `projection.site` knows later additions."""
    time: TimeScale
    wall_s: Callable[[], float]
    store: Store
    historian: Historian | None
    """None where it runs elsewhere."""
    peer: Peer
    strategist_probe: StrategistProbe
    projection: Projection
    joinings: Joinings
    hub: Hub
    recorder: Recorder | None
    """None where nothing is recorded."""
    replay: ReplayReader
    catalogue: Catalogue
    database_sync: DatabaseSync
    health: Health
    metrics: Metrics
    access: Access
    outbox: Outbox
    placement: OrderPlacement
    actions: OrderActions
    changing: OrderChanging
    change_feed: ChangeFeed
    completions: Completions
    reconciliation: Reconciliation
    estimates: EstimateKeeper
    transports: PlainTransports
    scheduler: Scheduler
    commands: Commands
    alerts: AlertMonitor
    exclusions: Exclusions
    closings: Closings
    area_pause: AreaPause
    carrying: Carrying
    duty: DutyRota
    faults: FaultInjection
    scenario: ScenarioPlay
    ledger: Ledger
    shift_player: ShiftPlayer
    shift_reporter: ShiftReporter
    dxf_plans: DxfPlans
    panels: Panels
    side_work: SideWork
    renderings: Renderings
    supervisor: Supervisor

    def by_type(self) -> dict[type[Any], object]:
        """The services for routers and middleware."""
        return {
            Settings: self.settings,
            Store: self.store,
            Access: self.access,
            Panels: self.panels,
            SideWork: self.side_work,
            Renderings: self.renderings,
            Projection: self.projection,
            Joinings: self.joinings,
            Hub: self.hub,
            ReplayReader: self.replay,
            Recorder: self.recorder,
            Catalogue: self.catalogue,
            Peer: self.peer,
            Health: self.health,
            Metrics: self.metrics,
            OrderPlacement: self.placement,
            OrderActions: self.actions,
            OrderChanging: self.changing,
            ChangeFeed: self.change_feed,
            EstimateKeeper: self.estimates,
            PlainTransports: self.transports,
            Scheduler: self.scheduler,
            Outbox: self.outbox,
            Completions: self.completions,
            Commands: self.commands,
            AlertMonitor: self.alerts,
            Exclusions: self.exclusions,
            Closings: self.closings,
            AreaPause: self.area_pause,
            Carrying: self.carrying,
            DutyRota: self.duty,
            TimeScale: self.time,
            FaultInjection: self.faults,
            ScenarioPlay: self.scenario,
            Ledger: self.ledger,
            ShiftPlayer: self.shift_player,
            ShiftReporter: self.shift_reporter,
            DxfPlans: self.dxf_plans,
            Supervisor: self.supervisor,
        }


def open_services(
    *,
    settings: Settings,
    plant: PlantFile,
    bus: Bus,
    store: Store,
    time: TimeScale,
    authority: SigningKey,
    incarnation: int,
    historian: Historian | None,
    panels: Panels | None,
    faults: FaultInjector | None,
    scenario: ScenarioPlayer | None,
    collectors: Iterable[Collector],
    wall_s: Callable[[], float],
    hasher: Hasher | None,
    operators: OperatorHost | None,
) -> Services:
    """Make the services; `dray.gateway.app.create_app` describes the arguments."""
    peer = Peer(bus, Keys(plant.plant), settings.gateway_name, incarnation)
    projection = Projection(plant, time, fault_injection=faults is not None, wall_s=wall_s)
    recorder = None
    if settings.replay_days > 0:
        name, kept_s = f"{settings.gateway_name}.{incarnation}", settings.replay_days * DAY_S
        recorder = Recorder(projection, store, wall_s, name=name, kept_s=kept_s)
    strategists = strategists_of(settings.strategists)
    strategist_probe = StrategistProbe(peer.send, strategists)
    catalogue = Catalogue(store, projection)
    products = projection.site.products
    outbox = Outbox(
        send=peer.send,
        time=time,
        wall_s=wall_s,
        products=products,
        strategists=strategists,
        definition_of=catalogue.definition_of,
        parts_of=catalogue.parts_of,
    )
    placing = Placing(store.database, keys_kept_s=KEYS_KEPT_S)
    closings = Closings(store, projection, authority, peer.tell_all, time=time, wall_s=wall_s)
    commands = Commands(
        peer.send,
        authority=authority,
        projection=projection,
        floor=projection.site.plant,
        time=time,
        wall_s=wall_s,
        name=f"{settings.gateway_name}.{incarnation}",
        timeout_s=settings.command_timeout_s,
    )
    transports = PlainTransports(store, projection, peer.send, time, wall_s)
    side_work = SideWork()
    placement = OrderPlacement(store, placing, projection, outbox, wall_s)
    return Services(
        settings=settings,
        plant=plant,
        time=time,
        wall_s=wall_s,
        store=store,
        historian=historian,
        peer=peer,
        strategist_probe=strategist_probe,
        projection=projection,
        joinings=Joinings(projection),
        hub=Hub(
            projection,
            wall_s=wall_s,
            rate_hz=settings.stream_rate_hz,
            queue_frames=settings.stream_queue_frames,
            clients=settings.stream_clients,
            each=settings.stream_clients_each,
            record=None if recorder is None else recorder.note,
        ),
        recorder=recorder,
        replay=ReplayReader(store, recorder, projection),
        catalogue=catalogue,
        database_sync=DatabaseSync(store, projection, outbox.follow, catalogue.look),
        health=Health(store, peer, strategist_probe, historian),
        metrics=Metrics(collectors),
        access=open_access(settings, store, wall_s, hasher),
        outbox=outbox,
        placement=placement,
        actions=OrderActions(store, projection, outbox, wall_s),
        changing=OrderChanging(store, projection, outbox, wall_s),
        change_feed=ChangeFeed(store),
        completions=Completions(store, outbox, projection, wall_s),
        reconciliation=Reconciliation(store, outbox, wall_s),
        estimates=EstimateKeeper(store, projection, wall_s),
        transports=transports,
        scheduler=Scheduler(store, Runs(transports, placement), wall_s),
        commands=commands,
        alerts=AlertMonitor(projection, store, wall_s),
        exclusions=Exclusions(
            store, projection, commands, peer.tell_all, wall_s=wall_s, own=settings.gateway_name
        ),
        closings=closings,
        area_pause=AreaPause(commands, closings, projection),
        carrying=Carrying(store, projection, authority, peer.tell_all, time=time, wall_s=wall_s),
        duty=DutyRota(operators, authority, names=settings.operator_names == "name", wall_s=wall_s),
        faults=FaultInjection(faults, projection.faults),
        scenario=ScenarioPlay(scenario, projection.scenarios),
        ledger=Ledger(store),
        shift_player=ShiftPlayer(
            lambda: side_work.do(PLAYER, as_yaml, msgspec.json.encode(projection.site.plant.file).decode())
        ),
        shift_reporter=ShiftReporter(store, projection, recorder, time.speed),
        dxf_plans=DxfPlans(),
        panels=panels or Panels(),
        side_work=side_work,
        renderings=Renderings(side_work),
        supervisor=Supervisor(),
    )


async def restore(services: Services) -> None:
    """Read from SQL what is needed before messages and requests arrive.

    Raises:
        UnavailableError: the database cannot be read or written.
    """
    async with services.store.write() as work:
        await services.catalogue.look(work)
        await work.products.replace(services.projection.site.plant.file.products)
        await services.catalogue.recall(work)
    await services.database_sync.restore()
    async with services.store.read() as work:
        await backfill_news(work, services.projection.news, services.time)
    await services.alerts.restore()
    await services.exclusions.restore()
    await services.closings.restore()
    await services.carrying.restore()


def measure(services: Services) -> None:
    """Register the services' own values with Prometheus."""
    state = State(
        projection=services.projection,
        hub=services.hub,
        peer=services.peer,
        strategist_probe=services.strategist_probe,
        health=services.health,
        store=services.store,
        supervisor=services.supervisor,
        wall_s=services.wall_s,
    )
    services.metrics.add(state)
    if services.historian is not None:
        services.metrics.add(History(services.historian))


@asynccontextmanager
async def running(services: Services, beside: Beside | None) -> AsyncIterator[None]:
    """Join the bus, and run the services within the context."""
    access, projection = services.access, services.projection
    # It samples additions from now on: restored values are in SQL already.
    sampler = Sampler(projection, services.store, services.wall_s)
    inbox = Inbox(
        meter=services.metrics.meter,
        strategist_probe=services.strategist_probe,
        completions=services.completions,
        outbox=services.outbox,
        reconciliation=services.reconciliation,
        transports=services.transports,
        commands=services.commands,
        projection=projection,
        plant_s=lambda: services.time.to_plant_s(services.wall_s()),
    )
    async with AsyncExitStack() as stack:
        if services.historian is not None:
            await stack.enter_async_context(services.historian.running(projection.fold))
        stack.push_async_callback(sampler.sample)
        if services.recorder is not None:
            stack.push_async_callback(services.recorder.close)
        stack.callback(services.peer.leave)
        stack.push_async_callback(services.side_work.close)
        stack.push_async_callback(services.shift_player.close)
        stack.push_async_callback(_last_lines, access.audit_log)
        services.peer.join(inbox.receive)
        tasks = await stack.enter_async_context(asyncio.TaskGroup())
        run = [
            tasks.create_task(services.supervisor.keep(type(each).__name__, each.run))
            for each in (
                services.outbox,
                services.completions,
                services.transports,
                services.estimates,
                services.scheduler,
                services.alerts,
                services.exclusions,
                services.closings,
                services.carrying,
                services.duty,
                services.joinings,
                services.hub,
                access,
                access.watch,
                access.audit_log,
                services.strategist_probe,
                sampler,
                services.reconciliation,
                services.database_sync,
                *(() if services.recorder is None else (services.recorder,)),
            )
        ]
        await services.reconciliation.start()
        await services.transports.start()
        if beside is not None:
            await access.learn()
            await stack.enter_async_context(beside(services.commands, access))
        yield
        for task in run:
            task.cancel()


async def _last_lines(audit_log: AuditLog) -> None:
    """Write waiting audit log lines, if the database answers."""
    with suppress(UnavailableError):
        await audit_log.catch_up()
