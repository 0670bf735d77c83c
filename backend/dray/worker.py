r"""The asyncio shell of one agent: an inbox, a timer, and the carrying out of effects.

The agent decides, the worker acts. The worker owns what an agent must not touch: the bus, the clock,
the body, the task that it all runs in. One worker is one asyncio task; it sleeps until something has
come, and then handles all that has come.

    bus ----Heard----\                           /-- first ---> journal: Commit, Record
    clock --Woke------> inbox -> agent.handle() -+--- then --+-> bus:  Publish, Send, Record, Subscribe ...
    body ---Reported-/                                       \-> body: Instruct

What an agent must do is none of this module's business: that is `dray.protocol`. What it has told and
somebody missed is: the worker itself answers from the journal (`EventsAsked`), whoever the agent is.
"""

from __future__ import annotations

import asyncio
from collections import Counter, deque
from typing import TYPE_CHECKING, assert_never, cast

from dray import messages
from dray.errors import ProtocolViolation
from dray.messages.fact import EVENTS_PER_ANSWER
from dray.protocol.runtime.events import (
    NEVER_S,
    Agent,
    Commit,
    Effect,
    Event,
    Heard,
    Ignore,
    Instruct,
    Leave,
    Leaving,
    Publish,
    Record,
    Reported,
    Send,
    Started,
    Subscribe,
    Unsubscribe,
    Woke,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from dray.body import BodyState, Instruction, Report
    from dray.memory import Note
    from dray.messages.keys import Keys
    from dray.ports import Body, Bus, Clock, Journal, Session

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


_WOKEN = Woke(None)
"""Stands in the inbox for a wake-up: the body is sensed when the agent's turn comes, not before."""


class Worker:
    """Runs one agent.

    Args:
        agent: the pure state machine.
        bus: joined under the agent's id while `run` runs.
        clock: the plant's clock.
        keys: the plant's keys; facts are published on the agent's own.
        body: what the agent acts with; None for an agent that only talks.
        journal: where its commitments and its history are written down.

    Attributes:
        handled: events handled so far.
        dropped_heartbeats: heartbeats that a newer one of their sender has replaced, or that found the inbox full.
        dropped_messages: other messages that were beyond their sender's room, or pushed out of a full inbox.
        ignored: messages that changed nothing, by the agent's reason; reasons are few and fixed.
    """

    def __init__(
        self,
        agent: Agent,
        *,
        bus: Bus,
        clock: Clock,
        keys: Keys,
        body: Body | None,
        journal: Journal,
    ) -> None:
        self.agent = agent
        self.handled = 0
        self.dropped_heartbeats = 0
        self.dropped_messages = 0
        self.ignored: Counter[str] = Counter()
        self._bus = bus
        self._clock = clock
        self._events_key = keys.events(agent.id)
        self._body = body
        self._journal = journal
        self._facts = 0
        self._inbox: deque[Event | _Newest] = deque()
        self._crowd: _Crowd | None = None
        """Who fills the inbox, once it is crowded; None until then, and when the agent's turn comes."""
        self._wakes_s: list[float] = []
        """When the clock will call: each time is earlier than the one before it, so the last is next."""
        self._woken = False
        """A wake-up waits in the inbox; until its turn no other is needed."""
        self._late_s = 0.0
        """How much later than asked for the clock has called since the agent was woken last, at most."""
        self._waiter: asyncio.Future[None] | None = None
        self._session: Session | None = None
        """Its place on the bus while it lives."""
        self._stopping = False
        self._killed = False
        self._ended = False

    async def run(self) -> None:
        """Live: join the bus, handle events until the agent leaves, `stop`, `kill` or cancellation; leave the bus.

        Raises:
            whatever the agent raises: an agent with a bug ends, and says so.
        """
        if self._killed:
            return
        loop = asyncio.get_running_loop()
        session = self._session = self._bus.join(self.agent.id, self._on_message, self.agent.incarnation)
        try:
            if self._body is not None:
                self._body.attach(self._report)
            self._handle(Started(self._sense(), self._journal.memory, self._journal.lost), session)
            while not self._stopping:
                if not self._inbox:
                    self._waiter = loop.create_future()
                    await self._waiter
                self._handle_inbox(session)
                if self._inbox:
                    # Let others have their turn before whatever came in meanwhile.
                    await asyncio.sleep(0)
        finally:
            self._end()

    def leave(self) -> None:
        """Ask the agent to leave in order; `run` returns when nothing holds it any more. Twice is harmless."""
        self._inbox.append(Leaving())
        if self._waiter is not None:
            self._wake_task()

    def stop(self) -> None:
        """Let `run` return after the event in hand. Twice is harmless."""
        self._stopping = True
        self._wake_task()

    @property
    def waiting(self) -> int:
        """Events that have come in and wait for the agent."""
        return len(self._inbox)

    @property
    def ended(self) -> bool:
        """Whether this life is over."""
        return self._ended

    def kill(self) -> None:
        """End now, as a process does that is killed: between two effects, if need be.

        After the return nothing more is said, instructed or written, and another worker may run the
        agent's next life; `run` returns in its own time. Twice is harmless.
        """
        self._killed = True
        self._end()
        self._wake_task()

    def _end(self) -> None:
        """Leave bus and body; what is left already may belong to the next life."""
        self._stopping = self._ended = True
        session, self._session = self._session, None
        if session is not None:
            session.leave()
            if self._body is not None:
                self._body.attach(_turn_a_deaf_ear)

    # --- what comes in ---------------------------------------------------------------------------

    def _on_message(self, sender: str, message: messages.Message) -> None:
        event: Heard | _Newest | None = Heard(sender, message)
        if len(self._inbox) >= CROWDED:
            event = self._queue_up(cast(Heard, event))
        if event is None:
            return
        self._inbox.append(event)
        if self._waiter is not None:
            self._wake_task()

    def _report(self, report: Report) -> None:
        # Never dropped: a body says things once. It cannot flood either, for it answers to instructions.
        self._inbox.append(Reported(report))
        if self._waiter is not None:
            self._wake_task()

    def _wake(self) -> None:
        due_s = self._wakes_s.pop()
        if self._stopping:
            return
        now_s = self._clock.now_s()
        self._late_s = max(self._late_s, now_s - due_s)
        if now_s < self.agent.wake_at_s:
            # The agent has thought better of it since this call was asked for.
            self._arm()
        elif not self._woken:
            self._woken = True
            self._inbox.append(_WOKEN)
            if self._waiter is not None:
                self._wake_task()

    def _queue_up(self, heard: Heard) -> Heard | _Newest | None:
        """Decide what a crowded inbox does with a message that has just come; None where it does not wait in its own place."""
        crowd = self._crowd
        if crowd is None:
            crowd = self._crowd = _Crowd(self._inbox)
        if isinstance(heard.message, messages.Heartbeat):
            return self._queue_heartbeat(heard, crowd)
        if crowd.count[heard.sender] >= SENDER_ROOM:
            self.dropped_messages += 1
            return None
        if len(self._inbox) >= INBOX and not self._push_out(crowd):
            return None
        crowd.count[heard.sender] += 1
        return heard

    def _queue_heartbeat(self, heard: Heard, crowd: _Crowd) -> _Newest | None:
        waiting = crowd.beats.get(heard.sender)
        if waiting is None and len(self._inbox) < INBOX:
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
        for place, event in enumerate(self._inbox):
            if type(event) is Heard and event.sender == greediest:
                del self._inbox[place]
                crowd.count[greediest] -= 1
                return True
        return False

    def _wake_task(self) -> None:
        waiter, self._waiter = self._waiter, None
        if waiter is not None and not waiter.done():
            waiter.set_result(None)

    # --- the agent's turn ------------------------------------------------------------------------

    def _handle_inbox(self, session: Session) -> None:
        inbox = self._inbox
        self._crowd = None
        for _ in range(len(inbox)):
            event = inbox.popleft()
            if type(event) is _Newest:
                event = event.heard
            if event is _WOKEN:
                self._woken = False
                event, self._late_s = Woke(self._sense(), self._late_s), 0.0
            elif type(event) is Heard:
                kind = type(event.message)
                if kind is messages.EventsAsked:
                    self._tell_again(event.sender, cast(messages.EventsAsked, event.message), session)
                    continue
                if kind is messages.VehicleCommand:
                    event = Heard(event.sender, event.message, self._sense())
            self._handle(cast("Event", event), session)
            if self._stopping:
                return

    def _handle(self, event: Event, session: Session) -> None:
        effects = self.agent.handle(event, self._clock.now_s())
        self.handled += 1
        if effects:  # Most of what an agent hears changes nothing.
            written = self._write_down(effects)
            for effect in effects:
                if self._killed:
                    return
                self._carry_out(effect, written, session)
        self._arm()

    def _write_down(self, effects: list[Effect]) -> Iterator[messages.Event]:
        """Write all that a step wants kept, at once and before any of it is told.

        So the next life knows either the whole step or nothing of it: neither a memory whose fact nobody
        will ever hear, nor a number that was told and is given again.
        """
        events: list[messages.Event] = []
        changes: dict[str, Note | None] = {}
        for effect in effects:
            kind = type(effect)
            if kind is Record:
                events.append(self._number(cast(Record, effect).fact))
            elif kind is Commit:
                commit = cast(Commit, effect)
                changes[commit.name] = commit.note
        if events or changes:
            self._journal.write(events, changes)
        return iter(events)

    def _number(self, fact: messages.AnyFact) -> messages.Event:
        self._facts += 1
        return messages.Event(
            agent=self.agent.id,
            incarnation=self.agent.incarnation,
            number=self._facts,
            at_s=self._clock.now_s(),
            fact=fact,
        )

    def _carry_out(self, effect: Effect, written: Iterator[messages.Event], session: Session) -> None:
        # The most frequent first: this runs for everything that any agent does.
        if isinstance(effect, Publish):
            session.publish(effect.key, effect.message)
        elif isinstance(effect, Send):
            session.send(effect.to, effect.message)
        elif isinstance(effect, Record):
            session.publish(self._events_key, next(written))
        elif isinstance(effect, Instruct):
            self._instruct(effect.instruction)
        elif isinstance(effect, Subscribe):
            session.subscribe(effect.key)
        elif isinstance(effect, Unsubscribe):
            session.unsubscribe(effect.key)
        elif isinstance(effect, Ignore):
            self.ignored[effect.reason] += 1
        elif isinstance(effect, Leave):
            self.stop()
        elif not isinstance(effect, Commit):  # which is written down already
            assert_never(effect)

    def _tell_again(self, asker: str, asked: messages.EventsAsked, session: Session) -> None:
        """Answer from the journal, whichever of the agent's lives is asked about."""
        life = asked.incarnation
        first, last = self._journal.kept(life)
        start = max(first, asked.first)
        for event in self._journal.events(life, start, min(last, asked.last, start + EVENTS_PER_ANSWER - 1)):
            session.send(asker, event)
        answer = messages.EventsKept(incarnation=life, first=first, last=last, life=self.agent.incarnation)
        session.send(asker, answer)

    def _instruct(self, instruction: Instruction) -> None:
        if self._body is None:
            raise ProtocolViolation(f"{self.agent.id} has no body and wants {instruction!r} done")
        self._body.instruct(instruction)

    def _sense(self) -> BodyState | None:
        return None if self._body is None else self._body.sense()

    def _arm(self) -> None:
        """Ask the clock for one more call, if the agent wants to be woken before all that are asked for."""
        wake_s = self.agent.wake_at_s
        if self._woken or wake_s == NEVER_S:
            return
        if not self._wakes_s or wake_s < self._wakes_s[-1]:
            # What is past already is asked for now: nothing was late then but the agent's own wish.
            self._wakes_s.append(max(wake_s, self._clock.now_s()))
            self._clock.call_at(wake_s, self._wake)


def _is_newer(heartbeat: messages.Message, other: messages.Message) -> bool:
    """Whether a heartbeat was said after another one of the same agent."""
    said, before = cast("messages.AtvHeartbeat", heartbeat), cast("messages.AtvHeartbeat", other)
    return (said.incarnation, said.seq) > (before.incarnation, before.seq)


def _turn_a_deaf_ear(report: Report) -> None:
    """Where a body reports to when its agent has gone."""
