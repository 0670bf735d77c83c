"""The stream: a snapshot and then numbered deltas, to any number of browsers.

A frame is made at most `rate_hz` times a second and encoded once, however many clients there are. Each
client has a bounded queue. When it is full the client is too slow for differences: its queue is
emptied, and it gets a fresh snapshot when it can take one. So memory is bounded, the newest state wins,
and nobody waits for anybody else.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable

import msgspec

from dray.gateway.projection import Projection
from dray.gateway.views import FactoryView

QUIET_S = 1.0
"""A frame comes at least this often, if an empty one: panels turn amber after 3 s without."""

FACTORY_S = 1.0
"""The figures of the factory are computed this often: a person cannot read them faster."""


class Client:
    """One browser's queue.

    Args:
        hub: where its frames come from.
        size: frames that wait at most.
    """

    def __init__(self, hub: Hub, size: int) -> None:
        self._hub, self._size = hub, size
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
            frame = self._hub.snapshot()
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


class Hub:
    """Makes frames and hands them out.

    Args:
        projection: what is shown.
        wall_s: the wall clock.
        rate_hz: frames per wall second at most.
        queue_frames: frames that wait for one client at most.
        clients: how many there may be.
    """

    def __init__(
        self,
        projection: Projection,
        *,
        wall_s: Callable[[], float],
        rate_hz: float,
        queue_frames: int,
        clients: int,
    ) -> None:
        self._projection, self._wall_s = projection, wall_s
        self._pause_s, self._queue_frames, self._most = 1.0 / rate_hz, queue_frames, clients
        self._clients: set[Client] = set()
        self._encoder = msgspec.json.Encoder()
        self._snapshot: str | None = None
        self._number = 0
        self.snapshots = 0
        """Snapshots handed out."""
        self._framed_s = self._figured_s = -1.0
        self._factory: FactoryView | None = None

    def join(self) -> Client | None:
        """A queue for a new client; None when there are too many."""
        if len(self._clients) >= self._most:
            return None
        client = Client(self, self._queue_frames)
        self._clients.add(client)
        return client

    @property
    def joined(self) -> int:
        """How many clients there are."""
        return len(self._clients)

    @property
    def frames(self) -> int:
        """How many frames were made."""
        return self._number

    def leave(self, client: Client) -> None:
        """The client is gone; harmless when done twice."""
        self._clients.discard(client)

    def snapshot(self) -> str:
        """Everything, as of the newest frame: the next delta fits behind it."""
        self.snapshots += 1
        if self._snapshot is None:
            snapshot = self._projection.snapshot(self._number, self._wall_s())
            self._snapshot = self._encoder.encode(snapshot).decode()
            # It holds figures that no delta has told: the next ones are told whatever they are.
            self._factory = None
        return self._snapshot

    def tick(self) -> None:
        """Make a frame, if there is something to tell or it has been quiet for too long."""
        if not self._clients:
            self._projection.discard_changes()
            self._snapshot = None
            return
        now_s = self._wall_s()
        factory = self._new_figures(now_s)
        quiet = not 0 <= now_s - self._framed_s < QUIET_S
        if not (self._projection.changed or factory is not None or quiet):
            return
        self._number += 1
        self._framed_s = now_s
        self._snapshot = None
        frame = self._encoder.encode(self._projection.delta(self._number, now_s, factory)).decode()
        for client in self._clients:
            client.offer(frame)

    async def run(self) -> None:
        """Make frames until cancelled."""
        while True:
            await asyncio.sleep(self._pause_s)
            self.tick()

    def _new_figures(self, now_s: float) -> FactoryView | None:
        """The factory's figures, when it is time for them and they have changed."""
        if 0 <= now_s - self._figured_s < FACTORY_S:
            return None
        self._figured_s = now_s
        factory = self._projection.factory(now_s)
        if factory == self._factory:
            return None
        self._factory = factory
        return factory
