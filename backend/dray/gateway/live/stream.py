"""The stream: a snapshot and then numbered deltas, to any number of browsers.

Those who see the same share a room: the whole plant is one, the plant without its orders, and each set of areas. A frame is made at most
`rate_hz` times a second and encoded once per room, however many clients are in it. Each client has a
bounded queue. When it is full the client is too slow for differences: its queue is emptied, and it gets a
fresh snapshot when it can take one. So memory is bounded, the newest state wins, and nobody waits for
anybody else.
"""

from __future__ import annotations

import asyncio
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import msgspec

from dray.gateway.access.principal import Principal, Scope
from dray.gateway.live.frames import Delta
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream_scopes import AreaScope, FactoryScope, StreamScope, WholeScope
from dray.gateway.live.views import AudienceView, FactoryView
from dray.gateway.live.visibility import AreaVisibility, FactoryVisibility

QUIET_S = 1.0
"""A frame comes at least this often, if an empty one: panels turn amber after 3 s without."""

FACTORY_S = 1.0
"""The figures of the factory are computed this often: a person cannot read them faster."""

NOBODYS = '"audience":null}'
"""How a snapshot ends that is encoded for all in a room; for each of them its own audience is put there."""

_encoder = msgspec.json.Encoder()


class Whole(Enum):
    """What is seen by whoever is limited to no areas."""

    PLANT = "plant"
    FACTORY = "factory"
    """All of it but its orders."""


Extent = frozenset[str] | Whole
"""What those in a room see: some areas, or the whole."""


class Client:
    """One browser's queue.

    Args:
        room: where its frames come from.
        owner: the caller, by kind and id.
        audience: whose it is.
        size: frames that wait at most.
    """

    def __init__(self, room: Room, owner: str, audience: AudienceView, size: int) -> None:
        self.room, self.owner, self._size = room, owner, size
        self._audience = _encoder.encode(audience).decode()
        self._frames: deque[str] = deque()
        self._lost = True
        """It needs a snapshot before anything else."""
        self._ready = asyncio.Event()
        self._ready.set()
        self.snapshots = 0
        """How many it was given; more than one tells of a slow client."""

    async def next_frame(self) -> str:
        """The next frame for this client, as soon as there is one."""
        await self._ready.wait()
        if self._lost:
            self._lost = False
            self.snapshots += 1
            frame = self.room.snapshot().removesuffix(NOBODYS) + f'"audience":{self._audience}}}'
        else:
            frame = self._frames.popleft()
        if not self._frames:
            self._ready.clear()
        return frame

    def offer(self, frame: str) -> None:
        """Put a frame into the queue, or give the queue up for a snapshot."""
        if self._lost:
            return
        if len(self._frames) >= self._size:
            self._frames.clear()
            self._lost = True
        else:
            self._frames.append(frame)
        self._ready.set()


@dataclass(slots=True)
class Made:
    """What was made in all rooms so far, those that are empty again too.

    Attributes:
        frames: deltas.
        snapshots: snapshots handed out; one per client, and more to slow ones.
    """

    frames: int = 0
    snapshots: int = 0


class Room:
    """Those who see the same.

    Args:
        scope: what they see.
        wall_s: the wall clock.
        made: counts what is made.
    """

    def __init__(self, scope: StreamScope, wall_s: Callable[[], float], made: Made) -> None:
        self._scope, self._wall_s, self._made = scope, wall_s, made
        self.clients: set[Client] = set()
        self._number = 0
        self._told_s = -1.0
        self._snapshot: str | None = None
        self.owes_figures = False
        """A snapshot held figures that no delta has told: the next ones are told whatever they are."""

    def snapshot(self) -> str:
        """Everything, as of the newest frame: the next delta fits behind it. It is nobody's yet."""
        self._made.snapshots += 1
        if self._snapshot is None:
            snapshot = self._scope.snapshot(self._number, self._wall_s())
            self._snapshot = _encoder.encode(snapshot).decode()
            self.owes_figures = True
        return self._snapshot

    def is_quiet(self, now_s: float) -> bool:
        """Whether it is time for a frame, whatever there is to tell."""
        return not 0 <= now_s - self._told_s < QUIET_S

    def tell(self, told: Delta) -> None:
        """Make a frame of what has changed in the plant, unless there is nothing to see of it here."""
        delta = self._scope.delta(told)
        if not (delta.tells or self.is_quiet(told.at_s)):
            return
        self._number += 1
        self._made.frames += 1
        self._told_s = told.at_s
        self._snapshot = None
        delta.number = self._number
        frame = _encoder.encode(delta).decode()
        for client in self.clients:
            client.offer(frame)


class Hub:
    """Makes frames and hands them out.

    Args:
        projection: what is shown.
        wall_s: the wall clock.
        rate_hz: frames per wall second at most.
        queue_frames: frames that wait for one client at most.
        clients: how many there may be.
        each: of one caller.
    """

    def __init__(
        self,
        projection: Projection,
        *,
        wall_s: Callable[[], float],
        rate_hz: float,
        queue_frames: int,
        clients: int,
        each: int,
    ) -> None:
        self._projection, self._wall_s = projection, wall_s
        self._pause_s, self._queue_frames = 1.0 / rate_hz, queue_frames
        self._most, self._each = clients, each
        self._of: Counter[str] = Counter()
        """How many clients each caller has."""
        self._rooms: dict[Extent, Room] = {}
        """By what is seen in them. Only those with somebody in them."""
        self._made = Made()
        self._figured_s = -1.0
        self._factory: FactoryView | None = None

    def join(self, who: Principal) -> Client | None:
        """A queue for a new client; None when there are too many, or too many of this caller."""
        owner = f"{who.kind}:{who.id}"
        if self.joined >= self._most or self._of[owner] >= self._each:
            return None
        self._of[owner] += 1
        extent = extent_of(who)
        room = self._rooms.get(extent)
        if room is None:
            room = self._rooms[extent] = Room(self._scope(extent), self._wall_s, self._made)
        client = Client(room, owner, audience_of(who), self._queue_frames)
        room.clients.add(client)
        return client

    @property
    def joined(self) -> int:
        """How many clients there are."""
        return sum(len(room.clients) for room in self._rooms.values())

    @property
    def frames(self) -> int:
        """How many frames were made, in all rooms."""
        return self._made.frames

    @property
    def snapshots(self) -> int:
        """How many snapshots were handed out."""
        return self._made.snapshots

    def leave(self, client: Client) -> None:
        """The client is gone; harmless when done twice."""
        if client not in client.room.clients:
            return
        client.room.clients.remove(client)
        self._of[client.owner] -= 1
        if not self._of[client.owner]:
            del self._of[client.owner]
        self._rooms = {extent: room for extent, room in self._rooms.items() if room.clients}

    def tick(self) -> None:
        """Make a frame, if there is something to tell or it has been quiet for too long."""
        if not self._rooms:
            self._projection.discard_changes()
            return
        now_s = self._wall_s()
        factory = self._new_figures(now_s)
        rooms = self._rooms.values()
        if not (
            self._projection.changed or factory is not None or any(room.is_quiet(now_s) for room in rooms)
        ):
            return
        told = self._projection.delta(0, now_s, factory)
        for room in rooms:
            room.tell(told)

    async def run(self) -> None:
        """Make frames until cancelled."""
        while True:
            await asyncio.sleep(self._pause_s)
            self.tick()

    def _scope(self, extent: Extent) -> StreamScope:
        if isinstance(extent, frozenset):
            return AreaScope(self._projection, AreaVisibility(self._projection, extent))
        if extent is Whole.PLANT:
            return WholeScope(self._projection)
        return FactoryScope(self._projection, FactoryVisibility(self._projection.site))

    def _new_figures(self, now_s: float) -> FactoryView | None:
        """The factory's figures, when it is time for them, somebody sees them and they have changed."""
        whole = [room for extent, room in self._rooms.items() if isinstance(extent, Whole)]
        if not whole or 0 <= now_s - self._figured_s < FACTORY_S:
            return None
        self._figured_s = now_s
        factory = self._projection.factory(now_s)
        if factory == self._factory and not any(room.owes_figures for room in whole):
            return None
        self._factory = factory
        for room in whole:
            room.owes_figures = False
        return factory


def extent_of(who: Principal) -> Extent:
    """What somebody sees."""
    if who.areas is not None:
        return who.areas
    return Whole.PLANT if who.may(Scope.ORDERS_READ) else Whole.FACTORY


def audience_of(who: Principal) -> AudienceView:
    """Who is shown the stream."""
    return AudienceView(
        role="" if who.role is None else who.role.value,
        name=who.name,
        areas=None if who.areas is None else tuple(sorted(who.areas)),
        station=who.station,
    )
