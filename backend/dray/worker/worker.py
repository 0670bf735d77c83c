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
from collections import Counter
from typing import TYPE_CHECKING, assert_never

from dray import messages
from dray.errors import ProtocolViolation
from dray.messages.history import EVENTS_PER_ANSWER
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
from dray.worker.inbox import Inbox

if TYPE_CHECKING:
    from collections.abc import Iterator

    from dray.body import BodyState, Instruction, Report
    from dray.memory import Note
    from dray.messages.keys import Keys
    from dray.ports import Body, Bus, Clock, Journal, Session

_SENSED = frozenset(
    {
        messages.VehicleCommand,
        messages.PlaceGranted,
        messages.PlaceConfirmed,
        messages.YieldAsked,
        messages.YieldRefused,
        messages.HoldsAsked,
    }
)
"""What a vehicle answers by where it is at that moment."""

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
        inbox: what has come and waits; it tells what it has dropped.
        ignored: messages that changed nothing, by the agent's reason; reasons are few and fixed.
        left: how the agent has ended its graceful shutdown; None while it has not.
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
        self.inbox = Inbox()
        self.ignored: Counter[str] = Counter()
        self.left: Leave | None = None
        self._bus = bus
        self._clock = clock
        self._events_key = keys.events(agent.id)
        self._body = body
        self._journal = journal
        self._facts = 0
        self._wakes_s: list[float] = []
        """When the clock will call: each time is earlier than the one before it, so the last is next."""
        self._woken = False
        """A wake-up waits in the inbox; until its turn no other is needed."""
        self._late_s = 0.0
        """How much later than asked for the clock has called since the agent was woken last, at most."""
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
        session = self._session = self._bus.join(self.agent.id, self.inbox.on_message, self.agent.incarnation)
        try:
            if self._body is not None:
                self._body.attach(self._report)
            self._handle(Started(self._sense(), self._journal.memory, self._journal.lost), session)
            while not self._stopping:
                if not self.inbox.waiting:
                    await self.inbox.next_event(loop)
                self._handle_inbox(session)
                if self.inbox.waiting:
                    # Let others have their turn before whatever came in meanwhile.
                    await asyncio.sleep(0)
        finally:
            self._end()

    def leave(self) -> None:
        """Ask the agent to shut down gracefully; `run` returns when nothing holds it any more. Twice is harmless."""
        self.inbox.put(Leaving())

    def stop(self) -> None:
        """Let `run` return after the event in hand. Twice is harmless."""
        self._stopping = True
        self.inbox.wake()

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
        self.inbox.wake()

    def _end(self) -> None:
        """Leave bus and body; what is left already may belong to the next life."""
        self._stopping = self._ended = True
        session, self._session = self._session, None
        if session is not None:
            session.leave()
            if self._body is not None:
                self._body.attach(_turn_a_deaf_ear)

    # --- what comes in ---------------------------------------------------------------------------

    def _report(self, report: Report) -> None:
        # Never dropped: a body says things once. It cannot flood either, for it answers to instructions.
        self.inbox.put(Reported(report))

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
            self.inbox.put(_WOKEN)

    # --- the agent's turn ------------------------------------------------------------------------

    def _handle_inbox(self, session: Session) -> None:
        for waiting in self.inbox.turn():
            event = waiting
            if type(event) is Heard:
                if type(event.message) in _SENSED:
                    event = Heard(event.sender, event.message, self._sense())
                elif type(event.message) is messages.EventsAsked:
                    self._tell_again(event.sender, event.message, session)
                    continue
            elif event is _WOKEN:
                self._woken = False
                event, self._late_s = Woke(self._sense(), self._late_s), 0.0
            self._handle(event, session)
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
            if isinstance(effect, Record):
                events.append(self._number(effect.fact))
            elif isinstance(effect, Commit):
                changes[effect.name] = effect.note
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
            self.left = effect
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


def _turn_a_deaf_ear(report: Report) -> None:
    """Where a body reports to when its agent has gone."""
