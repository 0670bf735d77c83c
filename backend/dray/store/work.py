"""One unit of work: all repositories in one transaction."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from sqlalchemy import text
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.access.addresses import Addresses
from dray.store.access.api_keys import ApiKeys
from dray.store.access.audit import Audit
from dray.store.access.lockouts import Lockouts
from dray.store.access.login_links import LoginLinks
from dray.store.access.people import People
from dray.store.access.secrets import Secrets
from dray.store.access.sessions import Sessions
from dray.store.access.signing_keys import SigningKeys
from dray.store.database.database import Database
from dray.store.database.migrate import upgrade
from dray.store.factory.alert_history import AlertHistory
from dray.store.factory.closures import Closures
from dray.store.factory.exclusions import Exclusions
from dray.store.factory.kpis import Kpis
from dray.store.factory.lane_traffic import LaneHours
from dray.store.factory.piece_hours import PieceHours
from dray.store.factory.plant_drafts import PlantDrafts
from dray.store.factory.removals import Removals
from dray.store.factory.report_targets import ReportTargets
from dray.store.factory.takeovers import Takeovers
from dray.store.history.beginnings import Beginning, Beginnings
from dray.store.history.events import Events
from dray.store.history.incarnations import Incarnations
from dray.store.history.samples import Samples
from dray.store.kept import Kept
from dray.store.orders.change_log import ChangeLog
from dray.store.orders.estimates import Estimates
from dray.store.orders.goals import Goals
from dray.store.orders.idempotency_keys import IdempotencyKeys
from dray.store.orders.milestones import Milestones
from dray.store.orders.order_changes import OrderChanges
from dray.store.orders.order_histories import OrderHistories
from dray.store.orders.orders import Orders
from dray.store.orders.products import Products
from dray.store.orders.progress import progress
from dray.store.orders.schedules import Schedules
from dray.store.orders.tasks import Tasks
from dray.store.orders.tracking_links import Links
from dray.store.orders.transports import Transports, transport_links
from dray.store.replay.recordings import Recordings
from dray.store.replay.spells import Spells
from dray.store.shifts import Shifts
from dray.store.tables import tracking_links


class Work:
    """The repositories, all in the transaction of `connection`."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection
        self.products = Products(connection)
        self.orders = Orders(connection)
        self.links = Links(connection, tracking_links, "order_id")
        self.transport_links = Links(connection, transport_links, "transport_id")
        self.order_changes = OrderChanges(connection)
        self.change_log = ChangeLog(connection)
        self.order_histories = OrderHistories(connection)
        self.estimates = Estimates(connection)
        self.goals = Goals(connection)
        self.milestones = Milestones(connection)
        self.transports = Transports(connection)
        self.schedules = Schedules(connection)
        self.events = Events(connection)
        self.samples = Samples(connection)
        self.tasks = Tasks(connection)
        self.alerts = AlertHistory(connection)
        self.closures = Closures(connection)
        self.plant_drafts = PlantDrafts(connection)
        self.removals = Removals(connection)
        self.exclusions = Exclusions(connection)
        self.recordings = Recordings(connection)
        self.spells = Spells(connection)
        self.kpis = Kpis(connection)
        self.lane_hours = LaneHours(connection)
        self.piece_hours = PieceHours(connection)
        self.report_targets = ReportTargets(connection)
        self.takeovers = Takeovers(connection)
        self.shifts = Shifts(connection)
        self.keys = IdempotencyKeys(connection)
        self.incarnations = Incarnations(connection)
        self.beginnings = Beginnings(connection)
        self.people = People(connection)
        self.sessions = Sessions(connection)
        self.login_links = LoginLinks(connection)
        self.api_keys = ApiKeys(connection)
        self.lockouts = Lockouts(connection)
        self.audit = Audit(connection)
        self.kept = Kept(connection)
        self.addresses = Addresses(connection)
        self.secrets = Secrets(connection)
        self.signing_keys = SigningKeys(connection)

    async def ping(self) -> None:
        """Run an empty query."""
        await self._connection.execute(text("SELECT 1"))


class Store:
    """Provides transactions over one open database."""

    def __init__(self, database: Database) -> None:
        self.database = database

    @asynccontextmanager
    async def read(self) -> AsyncIterator[Work]:
        """A transaction that only reads."""
        async with self.database.read() as connection:
            yield Work(connection)

    @asynccontextmanager
    async def write(self) -> AsyncIterator[Work]:
        """A transaction that is on disk when the block has ended, or undone when it raises."""
        async with self.database.write() as connection:
            yield Work(connection)

    async def next_incarnation(self, plant: str) -> int:
        """The number for agents of this plant that start now; call it once per start."""
        async with self.write() as work:
            return await work.incarnations.next(plant)

    async def begin_anew(self, plant: str, at_s: float) -> int:
        """The number for all agents of this plant, which start now without a memory; call it once per such start.

        Goals, tasks and transports that earlier lives have left open end, since no agent knows them. Their orders stay open: the
        factory is asked for what has not arrived.

        Args:
            plant: the plant.
            at_s: wall clock.
        """
        async with self.write() as work:
            incarnation = await work.incarnations.next(plant)
            await work.beginnings.add(Beginning(incarnation, at_s))
            await work.tasks.end_open(at_s)
            await work.transports.give_back_open(at_s)
            await work.goals.end_open(at_s)
            orders = await work.orders.open()
            goals_of = await work.goals.of_orders(order.id for order in orders)
            for order in orders:
                reached = progress(order.quantities, goals_of[order.id], order.incarnation, order.delivered)
                await work.orders.advance(order, reached, at_s)
            return incarnation

    async def close(self) -> None:
        """Close the database; harmless when repeated."""
        await self.database.close()


async def open_store(url: str) -> Store:
    """Open the database and migrate its tables.

    Args:
        url: as `Settings.database_url`.

    Raises:
        UnavailableError: opening, writing or migrating failed; contains a remedy.
    """
    database = await Database.open(url)
    try:
        await upgrade(database)
    except BaseException:
        await database.close()
        raise
    return Store(database)
