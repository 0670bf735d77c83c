"""The inbox of one agent: its waiting events in order, and the rules for dropping messages when it is crowded."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, cast

from dray import messages
from dray.protocol.runtime.events import Received

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Iterable

    from dray.protocol.runtime.events import Event

INBOX = 4096
"""Maximum waiting events: ten seconds of a plant of 300 agents that all talk to this one. An agent further behind has lost touch
anyway, and its peers repeat what matters."""

CROWDED = INBOX // 8
"""The filling above which messages are counted by sender. From then on only the newest heartbeat of each sender waits, because it
contains all that the older ones said."""

SENDER_ROOM = INBOX // 4
"""Maximum waiting messages of one sender in a crowded inbox. More are dropped, so that no sender fills an inbox alone or
displaces the messages of others."""


class _Newest:
    """A waiting heartbeat; a newer one of the same sender replaces it."""

    __slots__ = ("received",)

    def __init__(self, received: Received) -> None:
        self.received = received


class _Crowd:
    """The senders of the messages in a crowded inbox.

    Args:
        inbox: the events that wait already.
    """

    __slots__ = ("beats", "count")

    def __init__(self, inbox: Iterable[Event | _Newest]) -> None:
        self.count: Counter[str] = Counter(event.sender for event in inbox if type(event) is Received)
        self.beats: dict[str, _Newest] = {}
        """Heartbeats received since the inbox became crowded, by sender."""


class Inbox:
    """The waiting events of one agent, `INBOX` messages at most.

    Attributes:
        waiting: the events in their order, for inspection.
        dropped_heartbeats: heartbeats that a newer one of their sender replaced, or that found the inbox full.
        dropped_messages: other messages beyond their sender's limit, or displaced from a full inbox.
    """

    __slots__ = ("_crowd", "_waiter", "dropped_heartbeats", "dropped_messages", "waiting")

    def __init__(self) -> None:
        self.dropped_heartbeats = 0
        self.dropped_messages = 0
        self.waiting: list[Event | _Newest] = []
        self._crowd: _Crowd | None = None
        """The senders in a crowded inbox; None below that, and after each turn of the agent."""
        self._waiter: asyncio.Future[None] | None = None

    def put(self, event: Event) -> None:
        """Add an event that is never dropped: a report of the body, a wake-up, a request to leave."""
        self.waiting.append(event)
        if self._waiter is not None:
            self.wake()

    def on_message(self, sender: str, message: messages.Message) -> None:
        """Add a message, drop it, or drop another one for it."""
        received = Received(sender, message)
        if len(self.waiting) < CROWDED:
            self.waiting.append(received)
        elif (queued := self._queue_up(received)) is not None:
            self.waiting.append(queued)
        if self._waiter is not None:
            self.wake()

    def next_event(self, loop: asyncio.AbstractEventLoop) -> asyncio.Future[None]:
        """A future that ends at the next event, or at `wake`. Only one may be open."""
        waiter = self._waiter = loop.create_future()
        return waiter

    def wake(self) -> None:
        """End the wait for the next event."""
        waiter, self._waiter = self._waiter, None
        if waiter is not None and not waiter.done():
            waiter.set_result(None)

    def turn(self) -> list[Event]:
        """Remove and return all waiting events in their order; later ones wait for the next turn."""
        waiting, self.waiting = self.waiting, []
        if self._crowd is not None:
            self._crowd = None
            waiting = [event.received if type(event) is _Newest else event for event in waiting]
        return cast("list[Event]", waiting)

    def _queue_up(self, received: Received) -> Received | _Newest | None:
        """Place a new message in a crowded inbox; None where it replaces another one or is dropped."""
        crowd = self._crowd
        if crowd is None:
            crowd = self._crowd = _Crowd(self.waiting)
        if isinstance(received.message, messages.Heartbeat):
            return self._queue_heartbeat(received, crowd)
        if crowd.count[received.sender] >= SENDER_ROOM:
            self.dropped_messages += 1
            return None
        if len(self.waiting) >= INBOX and not self._push_out(crowd):
            return None
        crowd.count[received.sender] += 1
        return received

    def _queue_heartbeat(self, received: Received, crowd: _Crowd) -> _Newest | None:
        waiting = crowd.beats.get(received.sender)
        if waiting is None and len(self.waiting) < INBOX:
            newest = crowd.beats[received.sender] = _Newest(received)
            return newest
        self.dropped_heartbeats += 1
        if waiting is not None and _is_newer(received.message, waiting.received.message):
            waiting.received = received
        return None

    def _push_out(self, crowd: _Crowd) -> bool:
        """Drop the oldest message of the sender with the most; False when there is none."""
        self.dropped_messages += 1
        if not crowd.count:
            return False
        greediest = max(crowd.count, key=lambda sender: crowd.count[sender])
        for place, event in enumerate(self.waiting):
            if type(event) is Received and event.sender == greediest:
                del self.waiting[place]
                crowd.count[greediest] -= 1
                return True
        return False


def _is_newer(heartbeat: messages.Message, other: messages.Message) -> bool:
    """Whether a heartbeat is newer than another one of the same agent."""
    said, before = cast("messages.AtvHeartbeat", heartbeat), cast("messages.AtvHeartbeat", other)
    return (said.incarnation, said.seq) > (before.incarnation, before.seq)
