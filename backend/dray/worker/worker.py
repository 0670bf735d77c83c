r"""The asyncio shell of one agent: an inbox, a timer, and the execution of effects.

The agent decides, the worker acts. The worker owns what an agent must not touch: the bus, the clock, the body and the
task. One worker is one asyncio task. It sleeps until an event comes, and then handles all events that have come.

    bus ----Received----\                           /-- first ---> journal: Commit, Record
    clock --Woke------> inbox -> agent.handle() -+--- then --+-> bus:  Publish, Send, Record, Subscribe ...
    body ---Reported-/                                       \-> body: Instruct

`dray.protocol` decides what an agent does. The worker itself answers requests for missed events (`EventsAsked`) from
the journal, for agents of all kinds.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from itertools import starmap
from typing import TYPE_CHECKING, assert_never

from dray import messages
from dray.errors import ProtocolViolation
from dray.messages.history import EVENTS_PER_ANSWER, LIVES_TOLD, LifeKept
from dray.ports import nobody_hears
from dray.protocol.runtime.events import (
    NEVER_S,
    Agent,
    Commit,
    Effect,
    Event,
    Ignore,
    Instruct,
    Leave,
    Leaving,
    Publish,
    Received,
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
"""Messages that a vehicle answers by its position at that moment."""

_WOKEN = Woke(None)
"""The wake-up event in the inbox: the worker senses the body at the agent's turn, not before."""


class Worker:
    """Runs one agent.

    Args:
        agent: the pure state machine.
        bus: joined under the agent's id while `run` runs.
        clock: the plant's clock.
        keys: the plant's keys; facts are published on the agent's own.
        body: what the agent acts with; None for an agent that only talks.
        journal: the store of its commitments and its history.

    Attributes:
        handled: events handled so far.
        inbox: the waiting events, and the counts of dropped ones.
        ignored: messages without effect, by the agent's reason; reasons are few and fixed.
        left: the result of the agent's graceful shutdown; None before.
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
        """Times of the requested clock calls, latest first, so the last is next."""
        self._woken = False
        """A wake-up waits in the inbox; no other is needed until its turn."""
        self._late_s = 0.0
        """The largest delay of a clock call since the agent's last wake-up."""
        self._session: Session | None = None
        """Its session on the bus while it lives."""
        self._stopping = False
        self._killed = False
        self._ended = False

    async def run(self) -> None:
        """Live: join the bus, handle events until the agent leaves, `stop`, `kill` or cancellation; leave the bus.

        Raises:
            Exception: any that the agent raises: an agent with a bug ends, and says so.
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
                    # Let other tasks run before the events that came in meanwhile.
                    await asyncio.sleep(0)
        finally:
            self._end()

    def leave(self) -> None:
        """Ask the agent to shut down gracefully; `run` returns once nothing holds it. Twice is harmless."""
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
        """End now, as a killed process does: between two effects, if need be.

        After the return this life says, instructs and writes nothing more, and another worker may run the agent's next life. `run`
        returns later. Twice is harmless.
        """
        self._killed = True
        self._end()
        self.inbox.wake()

    def _end(self) -> None:
        """Leave bus and body, unless they belong to the next life already."""
        self._stopping = self._ended = True
        session, self._session = self._session, None
        if session is not None:
            session.leave()
            if self._body is not None:
                self._body.attach(nobody_hears)

    # --- what comes in ---------------------------------------------------------------------------

    def _report(self, report: Report) -> None:
        # Never dropped: a body reports each thing once. It cannot flood either, because it answers instructions.
        self.inbox.put(Reported(report))

    def _wake(self) -> None:
        due_s = self._wakes_s.pop()
        if self._stopping:
            return
        now_s = self._clock.now_s()
        self._late_s = max(self._late_s, now_s - due_s)
        if now_s < self.agent.wake_at_s:
            # The agent has chosen a later time since it requested this call.
            self._arm()
        elif not self._woken:
            self._woken = True
            self.inbox.put(_WOKEN)

    # --- the agent's turn ------------------------------------------------------------------------

    def _handle_inbox(self, session: Session) -> None:
        for waiting in self.inbox.turn():
            event = waiting
            if type(event) is Received:
                if type(event.message) in _SENSED:
                    event = Received(event.sender, event.message, self._sense())
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
        if effects:  # Most messages change nothing.
            written = self._write_down(effects)
            for effect in effects:
                if self._killed:
                    return
                self._carry_out(effect, written, session)
        self._arm()

    def _write_down(self, effects: list[Effect]) -> Iterator[messages.Event]:
        """Write all records of a step at once, and before any of them is published.

        So the next life knows either the whole step or nothing of it. Otherwise a note could lack its published fact, or a
        published number could be used twice.
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
        # The most frequent first: this runs for every effect of every agent.
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
        """Answer from the journal, for any life of the agent."""
        life = asked.incarnation
        first, last = self._journal.kept(life)
        start = max(first, asked.first)
        for event in self._journal.events(life, start, min(last, asked.last, start + EVENTS_PER_ANSWER - 1)):
            session.send(asker, event)
        answer = messages.EventsKept(
            incarnation=life,
            first=first,
            last=last,
            life=self.agent.incarnation,
            earlier=tuple(starmap(LifeKept, self._journal.earlier(self.agent.incarnation, LIVES_TOLD))),
        )
        session.send(asker, answer)

    def _instruct(self, instruction: Instruction) -> None:
        if self._body is None:
            raise ProtocolViolation(f"{self.agent.id} has no body and wants {instruction!r} done")
        self._body.instruct(instruction)

    def _sense(self) -> BodyState | None:
        return None if self._body is None else self._body.sense()

    def _arm(self) -> None:
        """Request another clock call, if the agent wants to wake before all requested ones."""
        wake_s = self.agent.wake_at_s
        if self._woken or wake_s == NEVER_S:
            return
        if not self._wakes_s or wake_s < self._wakes_s[-1]:
            # A past wake time is requested for now, so that it does not count as a late clock.
            self._wakes_s.append(max(wake_s, self._clock.now_s()))
            self._clock.call_at(wake_s, self._wake)
