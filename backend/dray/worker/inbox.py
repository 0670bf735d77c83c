"""The inbox of one agent: what has come and waits for the agent's turn, in its order, and what is dropped when it is crowded."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, cast

from dray import messages
from dray.protocol.runtime.events import Heard

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Iterable

    from dray.protocol.runtime.events import Event

INBOX = 4096
"""Events that wait for an agent. Ten seconds of a plant of 300 agents that all talk to this one; an agent
that is further behind has lost touch anyway, and its peers repeat what matters."""

CROWDED = INBOX // 8
"""From this filling on it is counted whose messages wait: below, nobody is in anybody's way. Of every sender only
the newest heartbeat waits from then on: it says all that the older ones have said."""

SENDER_ROOM = INBOX // 4
"""Messages of one sender that wait in a crowded inbox. What is beyond that is the sender's own loss: nobody fills
an inbox alone, and nobody pushes out what others have said."""


class _Newest:
    """A heartbeat that waits; a newer one of the same sender takes its place."""

    __slots__ = ("heard",)

    def __init__(self, heard: Heard) -> None:
        self.heard = heard


class _Crowd:
    """Whose messages wait in a crowded inbox.

    Args:
        inbox: what waits already.
    """

    __slots__ = ("beats", "count")

    def __init__(self, inbox: Iterable[Event | _Newest]) -> None:
        self.count: Counter[str] = Counter(event.sender for event in inbox if type(event) is Heard)
        self.beats: dict[str, _Newest] = {}
        """The heartbeats that have come since it is crowded, by sender."""


class Inbox:
    """Events that wait for one agent, `INBOX` messages at most.

    Attributes:
        waiting: they, in their order; to look at.
        dropped_heartbeats: heartbeats that a newer one of their sender has replaced, or that found the inbox full.
        dropped_messages: other messages that were beyond their sender's room, or pushed out of a full inbox.
    """

    __slots__ = ("_crowd", "_waiter", "dropped_heartbeats", "dropped_messages", "waiting")

    def __init__(self) -> None:
        self.dropped_heartbeats = 0
        self.dropped_messages = 0
        self.waiting: list[Event | _Newest] = []
        self._crowd: _Crowd | None = None
        """Who fills the inbox, once it is crowded; None until then, and when the agent's turn comes."""
        self._waiter: asyncio.Future[None] | None = None

    def put(self, event: Event) -> None:
        """Take in what is never dropped: a report of the body, a wake-up, the wish to leave."""
        self.waiting.append(event)
        if self._waiter is not None:
            self.wake()

    def on_message(self, sender: str, message: messages.Message) -> None:
        """Take in a message, or drop it, or drop another one for it."""
        heard = Heard(sender, message)
        if len(self.waiting) < CROWDED:
            self.waiting.append(heard)
        elif (queued := self._queue_up(heard)) is not None:
            self.waiting.append(queued)
        if self._waiter is not None:
            self.wake()

    def next_event(self, loop: asyncio.AbstractEventLoop) -> asyncio.Future[None]:
        """Done when something has come, or at `wake`. One at a time."""
        waiter = self._waiter = loop.create_future()
        return waiter

    def wake(self) -> None:
        """End the wait for the next event."""
        waiter, self._waiter = self._waiter, None
        if waiter is not None and not waiter.done():
            waiter.set_result(None)

    def turn(self) -> list[Event]:
        """Take out all that waits now, in its order; what comes in meanwhile waits for the next turn."""
        waiting, self.waiting = self.waiting, []
        if self._crowd is not None:
            self._crowd = None
            waiting = [event.heard if type(event) is _Newest else event for event in waiting]
        return cast("list[Event]", waiting)

    def _queue_up(self, heard: Heard) -> Heard | _Newest | None:
        """Decide what a crowded inbox does with a message that has just come; None where it does not wait in its own place."""
        crowd = self._crowd
        if crowd is None:
            crowd = self._crowd = _Crowd(self.waiting)
        if isinstance(heard.message, messages.Heartbeat):
            return self._queue_heartbeat(heard, crowd)
        if crowd.count[heard.sender] >= SENDER_ROOM:
            self.dropped_messages += 1
            return None
        if len(self.waiting) >= INBOX and not self._push_out(crowd):
            return None
        crowd.count[heard.sender] += 1
        return heard

    def _queue_heartbeat(self, heard: Heard, crowd: _Crowd) -> _Newest | None:
        waiting = crowd.beats.get(heard.sender)
        if waiting is None and len(self.waiting) < INBOX:
            newest = crowd.beats[heard.sender] = _Newest(heard)
            return newest
        self.dropped_heartbeats += 1
        if waiting is not None and _is_newer(heard.message, waiting.heard.message):
            waiting.heard = heard
        return None

    def _push_out(self, crowd: _Crowd) -> bool:
        """Drop the oldest message of whoever has most of them here; False when nobody has any."""
        self.dropped_messages += 1
        if not crowd.count:
            return False
        greediest = max(crowd.count, key=lambda sender: crowd.count[sender])
        for place, event in enumerate(self.waiting):
            if type(event) is Heard and event.sender == greediest:
                del self.waiting[place]
                crowd.count[greediest] -= 1
                return True
        return False


def _is_newer(heartbeat: messages.Message, other: messages.Message) -> bool:
    """Whether a heartbeat was said after another one of the same agent."""
    said, before = cast("messages.AtvHeartbeat", heartbeat), cast("messages.AtvHeartbeat", other)
    return (said.incarnation, said.seq) > (before.incarnation, before.seq)
