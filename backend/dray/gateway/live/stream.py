"""The stream: a snapshot, then numbered deltas, to any number of browsers.

Clients that see the same at the same pace share a room: the whole plant, the plant without orders, or a set
of areas. A room makes at most `rate_hz` frames a second, a calm room one, and encodes each frame once for all
clients. A frame holds at most `PORTION` orders and tasks, so that none holds up the loop; later frames bring
the rest of a snapshot. Each client has a bounded queue. A full queue means a slow client: its queue is
emptied, it gets a fresh snapshot when ready, and moves to the calm room for a minute. So memory is bounded,
the newest state wins, and no client delays another.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

import msgspec

from dray.gateway.access.principal import Principal, Scope
from dray.gateway.live.frames import PORTION, Delta
from dray.gateway.live.plant_picture import PlantPicture
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream_scopes import AreaScope, FactoryScope, StreamScope, WholeScope
from dray.gateway.live.updates import Updates
from dray.gateway.live.views import AudienceView, FactoryView
from dray.gateway.live.visibility import AreaVisibility, FactoryVisibility

QUIET_S = 1.0
"""Maximum seconds between frames, empty ones included: panels turn amber after 3 s without. In a calm room
also the minimum."""

CALM_S = 60.0
"""Seconds that a slow client stays in the calm room before it is tried in the live room again."""

FACTORY_S = 1.0
"""Seconds between two computations of the factory's figures: people cannot read faster."""

NOBODYS = '"audience":null}'
"""End of a room's encoded snapshot; each client's own audience replaces it."""

_encoder = msgspec.json.Encoder()


class Whole(Enum):
    """What callers who are not limited to areas see."""

    PLANT = "plant"
    FACTORY = "factory"
    """The plant without its orders."""


Extent = frozenset[str] | Whole
"""What a room shows: some areas, or the whole."""


class Pace(Enum):
    """How often the clients of a room get frames."""

    LIVE = "live"
    CALM = "calm"


class Client:
    """One browser's queue.

    Args:
        room: the source of its frames.
        owner: the caller, by kind and id.
        audience: its reader.
        size: maximum frames in the queue.
    """

    def __init__(self, room: Room, owner: str, audience: AudienceView, size: int) -> None:
        self.room, self.owner, self._size = room, owner, size
        self._audience = _encoder.encode(audience).decode()
        self._frames: deque[str] = deque()
        self._lost = True
        """Whether it needs a snapshot next."""
        self._ready = asyncio.Event()
        self._ready.set()
        self.snapshots = 0
        """Number of snapshots given; more than one means a slow client."""

    async def next_frame(self) -> str:
        """Wait for the next frame of this client."""
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

    def offer(self, frame: str) -> bool:
        """Queue a frame; if the queue is full, drop it for a snapshot and return False."""
        if self._lost:
            return True
        if len(self._frames) >= self._size:
            self.start_anew(self.room)
            return False
        self._frames.append(frame)
        self._ready.set()
        return True

    def start_anew(self, room: Room) -> None:
        """Send a snapshot next, then the frames of this room."""
        self.room = room
        self._frames.clear()
        self._lost = True
        self._ready.set()


@dataclass(slots=True)
class Made:
    """Totals of all rooms, including closed ones.

    Attributes:
        frames: number of deltas.
        snapshots: number of snapshots sent: one per client, more to slow ones.
    """

    frames: int = 0
    snapshots: int = 0


class Room:
    """Clients that see the same.

    Args:
        scope: what they see.
        wall_s: the wall clock.
        made: the totals.
        pace: how often they get frames.
    """

    def __init__(self, scope: StreamScope, wall_s: Callable[[], float], made: Made, pace: Pace) -> None:
        self._scope, self._wall_s, self._made, self._pace = scope, wall_s, made, pace
        self._updates = Updates()
        self.clients: set[Client] = set()
        self._number = 0
        self._told_s = -math.inf
        self._snapshot: str | None = None
        self._owed: dict[str, deque[str]] = {}
        """Names that a snapshot left out and no frame has sent yet, by collection."""
        self.owes_figures = False
        """Whether a snapshot held figures that no delta sent: the next figures are sent even if unchanged."""

    def snapshot(self) -> str:
        """The state as of the newest frame, without an audience; the next delta follows it."""
        self._made.snapshots += 1
        if self._snapshot is None:
            snapshot = self._scope.snapshot(self._number, self._wall_s(), PORTION)
            self._snapshot = _encoder.encode(snapshot).decode()
            self._updates.tell_whole()
            self._owe(self._scope.rest(PORTION))
            self.owes_figures = True
        return self._snapshot

    @property
    def has_more(self) -> bool:
        """Whether there are changes that no frame had room for yet."""
        return self._updates.waiting or any(self._owed.values())

    def is_quiet(self, steady_s: float) -> bool:
        """Whether a frame is due even without changes."""
        return steady_s - self._told_s >= QUIET_S

    def tell(self, told: Delta, steady_s: float) -> list[Client]:
        """Make a frame of the plant's changes, if it is time and this room sees any of them.

        Args:
            told: the changes.
            steady_s: now, on the clock of `is_quiet`.

        Returns:
            The clients that were too slow for it.
        """
        self._updates.note(self._scope.delta(told))
        if not self.is_quiet(steady_s) and (self._pace is Pace.CALM or not self.has_more):
            return []
        for collection, names in self._owed.items():
            these = [names.popleft() for _ in range(min(PORTION, len(names)))]
            if these:
                self._updates.tell(collection, self._scope.views(collection, these))
        self._number += 1
        self._made.frames += 1
        self._told_s = steady_s
        self._snapshot = None
        frame = _encoder.encode(self._updates.frame(self._number, told.at_s, PORTION)).decode()
        return [client for client in self.clients if not client.offer(frame)]

    def _owe(self, rest: Mapping[str, Iterable[str]]) -> None:
        """Queue the rest of a snapshot for later frames.

        What was owed before comes first, even if snapshots are frequent.
        """
        for collection, names in rest.items():
            left = dict.fromkeys(names)
            before = dict.fromkeys(name for name in self._owed.get(collection, ()) if name in left)
            self._owed[collection] = deque(before | left)


class Hub:
    """Makes frames and hands them out.

    Args:
        projection: the live projection.
        wall_s: the wall clock for the frames' times.
        steady_s: a clock independent of changes to the wall clock.
        rate_hz: maximum frames per second.
        queue_frames: maximum frames in a client's queue.
        clients: maximum clients.
        each: maximum clients of one caller.
        record: gets the whole plant's deltas, even without clients.
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
        record: Callable[[Delta], None] | None = None,
        steady_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._record, self._recorded_s = record, -1.0
        self._steady_s = steady_s
        self._projection, self._wall_s = projection, wall_s
        self._pause_s, self._queue_frames = 1.0 / rate_hz, queue_frames
        self._most, self._each = clients, each
        self._of: Counter[str] = Counter()
        """Number of clients per caller."""
        self._rooms: dict[tuple[Extent, Pace], Room] = {}
        """Rooms with clients, by what they show."""
        self._slow: dict[Client, tuple[Extent, float]] = {}
        """Slow clients in a calm room -> what they see, and until when they stay."""
        self._made = Made()
        self._figured_s = -math.inf
        self._factory: FactoryView | None = None

    def join(self, who: Principal, pace: Pace = Pace.LIVE) -> Client | None:
        """Add a client; None when there are too many, or too many of this caller."""
        owner = f"{who.kind}:{who.id}"
        if self.joined >= self._most or self._of[owner] >= self._each:
            return None
        self._of[owner] += 1
        room = self._room(extent_of(who), pace)
        client = Client(room, owner, audience_of(who), self._queue_frames)
        room.clients.add(client)
        return client

    @property
    def joined(self) -> int:
        """Number of clients."""
        return sum(len(room.clients) for room in self._rooms.values())

    @property
    def frames(self) -> int:
        """Number of frames made, in all rooms."""
        return self._made.frames

    @property
    def snapshots(self) -> int:
        """Number of snapshots handed out."""
        return self._made.snapshots

    def leave(self, client: Client) -> None:
        """Remove a client; harmless when done twice."""
        if client not in client.room.clients:
            return
        client.room.clients.remove(client)
        self._of[client.owner] -= 1
        if not self._of[client.owner]:
            del self._of[client.owner]
        self._slow.pop(client, None)
        self._close_empty_rooms()

    def tick(self) -> None:
        """Make a frame, if anything changed or a frame is due."""
        if not self._rooms and self._record is None:
            self._projection.discard_changes()
            return
        now_s, steady_s = self._wall_s(), self._steady_s()
        self._try_again(steady_s)
        factory = self._new_figures(now_s, steady_s)
        rooms = self._rooms.values()
        if not (
            self._projection.changed
            or factory is not None
            or any(room.has_more or room.is_quiet(steady_s) for room in rooms)
            or (self._record is not None and not 0 <= now_s - self._recorded_s < QUIET_S)
        ):
            return
        told = self._projection.delta(0, now_s, factory, PORTION)
        if self._record is not None:
            self._recorded_s = now_s
            self._record(told)
        slow = [(client, *key) for key, room in self._rooms.items() for client in room.tell(told, steady_s)]
        for client, extent, pace in slow:
            if pace is Pace.LIVE:
                self._move(client, extent, Pace.CALM)
                self._slow[client] = extent, steady_s + CALM_S

    async def run(self) -> None:
        """Make frames until cancelled."""
        while True:
            await asyncio.sleep(self._pause_s)
            self.tick()

    def _room(self, extent: Extent, pace: Pace) -> Room:
        room = self._rooms.get((extent, pace))
        if room is None:
            room = self._rooms[extent, pace] = Room(
                _scope(self._projection, extent), self._wall_s, self._made, pace
            )
        return room

    def _close_empty_rooms(self) -> None:
        self._rooms = {key: room for key, room in self._rooms.items() if room.clients}

    def _move(self, client: Client, extent: Extent, pace: Pace) -> None:
        client.room.clients.remove(client)
        room = self._room(extent, pace)
        room.clients.add(client)
        client.start_anew(room)
        self._close_empty_rooms()

    def _try_again(self, steady_s: float) -> None:
        """Move slow clients back to the live room when their time is over."""
        for client, (extent, until_s) in list(self._slow.items()):
            if steady_s >= until_s:
                del self._slow[client]
                self._move(client, extent, Pace.LIVE)

    def _new_figures(self, now_s: float, steady_s: float) -> FactoryView | None:
        """The factory's figures, if they are due, changed and somebody sees them."""
        whole = [room for (extent, _), room in self._rooms.items() if isinstance(extent, Whole)]
        if not (whole or self._record) or steady_s - self._figured_s < FACTORY_S:
            return None
        self._figured_s = steady_s
        factory = self._projection.factory(now_s)
        if factory == self._factory and not any(room.owes_figures for room in whole):
            return None
        self._factory = factory
        for room in whole:
            room.owes_figures = False
        return factory


def scope_of(seen: PlantPicture, who: Principal) -> StreamScope:
    """The scope of a picture that a caller sees."""
    return _scope(seen, extent_of(who))


def _scope(seen: PlantPicture, extent: Extent) -> StreamScope:
    if isinstance(extent, frozenset):
        return AreaScope(seen, AreaVisibility(seen, extent))
    if extent is Whole.PLANT:
        return WholeScope(seen)
    return FactoryScope(seen, FactoryVisibility(seen.site))


def extent_of(who: Principal) -> Extent:
    """The extent that a caller sees."""
    if who.areas is not None:
        return who.areas
    return Whole.PLANT if who.may(Scope.ORDERS_READ) else Whole.FACTORY


def audience_of(who: Principal) -> AudienceView:
    """The reader of a stream, from its caller."""
    return AudienceView(
        role="" if who.role is None else who.role.value,
        name=who.name,
        areas=None if who.areas is None else tuple(sorted(who.areas)),
        station=who.station,
    )
