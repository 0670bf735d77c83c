"""The historian: it listens on the bus and writes agents' reports into SQL.

Nobody waits for it. Events are gathered in a bounded queue and written in batches, one transaction each; a repeated event is
one row. From the facts it updates goals and orders. When the database fails it retries later; when the queue is full the newest
events are dropped and counted.

It asks the agents for all events that it has missed, also while it was down: agents keep their newest events
(`dray.store.history.gaps` decides on the questions). So a history has holes only where an agent deleted events before
they were fetched; those are counted and logged.
"""

from __future__ import annotations

import asyncio
import logging
import time as clock
from collections import deque
from collections.abc import AsyncIterator, Callable, Collection, Sequence
from contextlib import asynccontextmanager
from functools import partial

from sqlalchemy.exc import DBAPIError

from dray.errors import UnavailableError
from dray.messages import AtvHeartbeat, Event, EventsKept, Heartbeat, MachineHeartbeat, Message
from dray.messages.keys import HISTORIAN, Keys
from dray.ports import Bus, Session
from dray.store.history.clocks import AGENTS_KEPT, Clocks, ToWall
from dray.store.history.gaps import Gaps
from dray.store.orders.progress import Goal, accepted_order, goal_of, life_with, note, progress
from dray.store.retention import Retention
from dray.store.work import Store, Work
from dray.supervision import Supervisor

QUEUE_EVENTS = 50_000
"""Maximum waiting events, some 25 MB: a minute of 1,000 vehicles while the disk is busy."""

QUEUE_SAMPLES = 5_000
"""Maximum waiting heartbeat samples; they matter less than events, so they have their own small queue."""

BATCH_EVENTS = 2_000
"""Maximum events per transaction: some 50 ms, so that orders do not wait long."""

SAMPLE_EVERY_S = 30.0
"""Factory seconds between two stored heartbeats of one agent: batteries and ways change slower."""

ASK_EVERY_S = 1.0
"""Wall seconds between two checks for missing events. A gap waits about as long before the first question, so that
checking costs little beside receiving."""

RETRY_S = (0.5, 30.0)
"""Wall seconds before the first and between later retries on a failing database, doubling."""

_log = logging.getLogger(__name__)


class Historian:
    """Writes history.

    Args:
        store: the store.
        bus: the bus of the agents.
        keys: the plant's.
        to_wall_s: plant clock to wall clock.
        life: its incarnation: the latest historian stays.
        agents: agents that are asked for history even before they are heard.
        linger_s: wall seconds in which events are gathered for one write.
        retention: deletes old data; None to keep all.
        queue_events: maximum waiting events.
        retry_s: see `RETRY_S`.
        wall_s: the wall clock.
        clocks: the agents' clock errors: times by a wrong clock are stored corrected. None to believe all
            clocks.
        to_plant_s: wall clock to plant clock; needed with `clocks`.
    """

    def __init__(
        self,
        *,
        store: Store,
        bus: Bus,
        keys: Keys,
        to_wall_s: ToWall,
        life: int = 0,
        agents: Collection[str] = (),
        linger_s: float = 0.2,
        retention: Retention | None = None,
        queue_events: int = QUEUE_EVENTS,
        retry_s: tuple[float, float] = RETRY_S,
        wall_s: Callable[[], float] = clock.time,
        clocks: Clocks | None = None,
        to_plant_s: ToWall | None = None,
    ) -> None:
        self._store, self._bus, self._keys = store, bus, keys
        self._to_wall_s, self._linger_s = to_wall_s, linger_s
        self._agents, self._life = agents, life
        self._wall_s = wall_s
        self._clocks, self._to_plant_s = clocks, to_plant_s
        self.retention = retention
        self.supervisor = Supervisor()
        self._queue_events, self._retry_s = queue_events, retry_s
        self._events: deque[tuple[float, Event]] = deque()
        """Waiting events, each with its time of reception."""
        self._writing_since_s: float | None = None
        """The reception time of the oldest event being written."""
        self._samples: deque[Heartbeat] = deque(maxlen=QUEUE_SAMPLES)
        self._sampled_at_s: dict[str, float] = {}
        self._gaps = Gaps()
        self._recovered: Callable[[Event], object] | None = None
        self._arrived, self._written, self._closing = asyncio.Event(), asyncio.Event(), asyncio.Event()
        self._written.set()
        self.kept = 0
        """Number of events written now or before."""
        self.lost = 0
        """Events that found the queue full, to be asked for again, or that the database refused."""
        self.failing = False
        """Whether the database is not writable."""

    @property
    def missing(self) -> int:
        """The count of event numbers that have not arrived yet."""
        return self._gaps.missing

    @property
    def gone(self) -> int:
        """The count of event numbers that will never arrive: the holes since its start."""
        return self._gaps.gone

    @property
    def waiting(self) -> int:
        """The number of received events that are not being written yet."""
        return len(self._events)

    @property
    def behind_s(self) -> float:
        """The age of the oldest received event that is not written yet; 0 for none."""
        since_s = self._writing_since_s
        if since_s is None and self._events:
            since_s = self._events[0][0]
        return 0.0 if since_s is None else self._now_s() - since_s

    @asynccontextmanager
    async def running(self, recovered: Callable[[Event], object] | None = None) -> AsyncIterator[None]:
        """Listen, ask and write; at the end, write all received events.

        Args:
            recovered: called with every event that was fetched later; other listeners in the process have missed it,
                too.
        """
        self._recovered = recovered
        async with self._store.read() as work:
            self._gaps = Gaps(await work.events.known(), self._now_s(), self._agents)
        session = self._bus.join(HISTORIAN, self.receive, self._life)
        session.subscribe(self._keys.all_events)
        session.subscribe(self._keys.all_heartbeats)
        keep = self.supervisor.keep
        writer = asyncio.create_task(keep("writes", self._write_on), name=HISTORIAN)
        beside = [asyncio.create_task(keep("asks", partial(self._ask_on, session)), name=f"{HISTORIAN} asks")]
        if self.retention is not None:
            forgets = keep("forgets", self.retention.run)
            beside.append(asyncio.create_task(forgets, name=f"{HISTORIAN} forgets"))
        try:
            yield
        finally:
            for task in beside:
                task.cancel()
            session.leave()
            self._closing.set()
            self._arrived.set()
            await writer

    def receive(self, sender: str, message: Message) -> None:
        """Take one message from the bus; never blocks."""
        if (
            self._clocks is not None
            and self._to_plant_s is not None
            and isinstance(message, Event | AtvHeartbeat | MachineHeartbeat)
        ):
            message = self._clocks.right(message, self._to_plant_s(self._wall_s()))
        match message:
            case Event():
                self._take_event(message)
            case AtvHeartbeat(atv=agent) | MachineHeartbeat(machine=agent):
                self._gaps.note_alive(agent, message.incarnation, self._now_s())
                self._take_heartbeat(agent, message)
            case EventsKept():
                if gone := self._gaps.answered(sender, message, self._now_s()):
                    life = message.incarnation
                    _log.warning("%s no longer has %d events, of its life %d or others", sender, gone, life)
            case _:
                pass

    async def written(self) -> None:
        """Wait until all received events are written."""
        await self._written.wait()

    def _take_event(self, event: Event) -> None:
        if len(self._events) >= self._queue_events:
            # Its number is not noted, so it counts as missing and is asked for when there is room.
            self._gaps.note_alive(event.agent, event.incarnation, self._now_s())
            self.lost += 1
            return
        was_missed = self._gaps.note(event.agent, event.incarnation, event.number, self._now_s())
        # First note its number, so that it is not asked for again, even if the other listener raises.
        self._events.append((self._now_s(), event))
        self._wake()
        if was_missed and self._recovered is not None:
            self._recovered(event)

    def _take_heartbeat(self, agent: str, heartbeat: Heartbeat) -> None:
        last_s = self._sampled_at_s.get(agent)
        # A clock that went back means a new life of the plant.
        if last_s is None or not last_s <= heartbeat.at_s < last_s + SAMPLE_EVERY_S:
            self._sampled_at_s.pop(agent, None)
            self._sampled_at_s[agent] = heartbeat.at_s
            if len(self._sampled_at_s) > AGENTS_KEPT:
                del self._sampled_at_s[next(iter(self._sampled_at_s))]
            self._samples.append(heartbeat)
            self._wake()

    def _wake(self) -> None:
        self._written.clear()
        self._arrived.set()

    def _now_s(self) -> float:
        return asyncio.get_running_loop().time()

    async def _ask_on(self, session: Session) -> None:
        while True:
            # Not while the database is down: events that cannot be stored stay with their agents.
            if not self.failing:
                for agent, question in self._gaps.due(self._now_s()):
                    session.send(agent, question)
            await asyncio.sleep(ASK_EVERY_S)

    async def _write_on(self) -> None:
        while not self._closing.is_set() or self._events or self._samples:
            await self._arrived.wait()
            await self._linger()
            events, samples = self._take_batch()
            await self._write_or_retry(events, samples)
            self._writing_since_s = None
            if not self._events and not self._samples:
                self._written.set()
                if not self._closing.is_set():
                    self._arrived.clear()

    async def _linger(self) -> None:
        if self._linger_s and not self._closing.is_set() and len(self._events) < BATCH_EVENTS:
            await self._closed_within(self._linger_s)

    async def _closed_within(self, wait_s: float) -> bool:
        try:
            async with asyncio.timeout(wait_s):
                await self._closing.wait()
        except TimeoutError:
            return False
        return True

    def _take_batch(self) -> tuple[list[Event], list[Heartbeat]]:
        count = min(len(self._events), BATCH_EVENTS)
        self._writing_since_s = self._events[0][0] if count else None
        events = [self._events.popleft()[1] for _ in range(count)]
        samples = list(self._samples)
        self._samples.clear()
        return events, samples

    async def _write_or_retry(self, events: list[Event], samples: list[Heartbeat]) -> None:
        wait_s = self._retry_s[0]
        while True:
            try:
                await self._write(events, samples)
            except UnavailableError as error:
                if not self.failing:
                    _log.warning("the database cannot be written (%s); trying again", error.reason)
                self.failing = True
                if await self._closed_within(wait_s):
                    self.lost += len(events)
                    _log.error("%d events were not written: the database failed to the end", len(events))
                    return
                wait_s = min(2 * wait_s, self._retry_s[1])
            except DBAPIError as error:
                await self._write_one_by_one(events, str(error.orig))
                return
            except Exception as error:  # noqa: BLE001 - whatever it is, it is about one of them
                # Our own bug: store the others nevertheless.
                _log.exception("%d events could not be written at once", len(events))
                await self._write_one_by_one(events, repr(error))
                return
            else:
                self.failing = False
                self.kept += len(events)
                return

    async def _write_one_by_one(self, events: list[Event], reason: str) -> None:
        """Store the good part of a batch that contains an event that can never be written."""
        if len(events) <= 1:
            self.lost += len(events)
            _log.warning("an event was refused by the database: %s: %r", reason, events)
            return
        for event in events:
            await self._write_or_retry([event], [])

    async def _write(self, events: Sequence[Event], samples: Sequence[Heartbeat]) -> None:
        async with self._store.write() as work:
            await work.piece_hours.add(events, self._to_wall_s)
            await work.events.add(events, self._to_wall_s)
            await work.takeovers.add(events, self._to_wall_s)
            await work.samples.add(samples, self._to_wall_s)
            await self._follow(work, events)
            await work.transports.follow(events, self._to_wall_s)
            await work.tasks.follow(events, self._to_wall_s)

    async def _follow(self, work: Work, events: Sequence[Event]) -> None:
        """Update goals and orders by these events."""
        lives: dict[str, int] = {}
        for event in events:
            if accepted := accepted_order(event):
                lives[accepted] = max(lives.get(accepted, 0), life_with(event))
        await work.orders.accept(lives)

        told = [(goal, event) for event in events if (goal := goal_of(event))]
        goals = await work.goals.many({goal for goal, _ in told}) if told else {}
        for goal, event in told:
            note(goals.setdefault(goal, Goal(goal)), event, self._to_wall_s)
        await work.goals.put(goals.values())

        touched = lives.keys() | {goal.order_id for goal in goals.values() if goal.order_id}
        orders = await work.orders.many(touched)
        goals_of = await work.goals.of_orders(order.id for order in orders)
        for order in orders:
            await work.orders.advance(
                order,
                progress(order.quantities, goals_of[order.id], order.incarnation, order.delivered),
                self._wall_s(),
            )
