"""An agent with its body, its time and what it has written down; it can crash and live again."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

import plentiful
from bodies import PlainBody

from dray.body import Report
from dray.memory import Note
from dray.messages import Message
from dray.protocol.runtime.events import (
    NEVER_S,
    Agent,
    Commit,
    Effect,
    Event,
    Instruct,
    Leave,
    Leaving,
    Publish,
    Received,
    Reported,
    Send,
    Started,
    Woke,
)

STEPS_PER_INSTANT = 200
"""More than any agent has alarms and any body reports: whoever needs more without time passing spins."""


class Actor:
    """One agent and its body, run by hand.

    Args:
        create: makes the agent, given its incarnation.
        body: what it acts with; None for none.
        watch: called with every effect, in order.

    Attributes:
        agent: the living agent; None while it is down.
        leaving: it was asked to leave in this life.
        now_s: the time of the last step.
        memory: what it has committed last, in whatever life.
        busiest: the most effects that one event has had.
    """

    def __init__(
        self,
        create: Callable[[int], Agent],
        body: PlainBody | None,
        watch: Callable[[Effect], None] = lambda _effect: None,
    ) -> None:
        self._create = create
        self._watch = watch
        self.body = body
        self.agent: Agent | None = None
        self.leaving = False
        self.now_s = 0.0
        self.incarnation = 0
        self.memory: dict[str, Note] = {}
        self.busiest = 0
        self._steps = 0
        self._queue: deque[Event] = deque()

    def start(self, now_s: float) -> None:
        """A life begins."""
        self._move(now_s)
        self._steps = 0
        self.incarnation += 1
        self.leaving = False
        self.agent = self._create(self.incarnation)
        body = None if self.body is None else self.body.sense()
        self._handle(Started(body, dict(self.memory)))

    def crash(self) -> None:
        """The life ends; the body goes on with what it was told to do."""
        self.agent = None

    def leave(self, now_s: float) -> None:
        """It is asked to leave; the life ends when it says so."""
        self._move(now_s)
        self.leaving = True
        self._handle(Leaving())

    def on_message(self, sender: str, message: Message, now_s: float) -> None:
        """A message arrives."""
        self._move(now_s)
        self._handle(Received(sender, message))

    def report(self, reports: Iterable[Report], now_s: float) -> None:
        """The body says something."""
        self._move(now_s)
        for report in reports:
            self._handle(Reported(report))

    @property
    def next_s(self) -> float:
        """When something is due."""
        wake_s = NEVER_S if self.agent is None else self.agent.wake_at_s
        return min(wake_s, NEVER_S if self.body is None else self.body.next_s)

    def step(self, now_s: float) -> None:
        """Do what is due: the body first."""
        self._move(now_s)
        body = self.body
        if body is not None and body.next_s <= now_s:
            for report in body.step(now_s):
                self._handle(Reported(report))
        elif self.agent is not None and self.agent.wake_at_s <= now_s:
            self._handle(Woke(None if body is None else body.sense()))

    def run(self, until_s: float) -> None:
        """Let time pass with nobody else around."""
        while self.next_s <= until_s:
            self.step(max(self.now_s, self.next_s))
        self._move(max(self.now_s, until_s))

    def _move(self, now_s: float) -> None:
        if now_s > self.now_s:
            self.now_s, self._steps = now_s, 0

    def _handle(self, event: Event) -> None:
        self._queue.append(event)
        while self._queue:
            event = self._queue.popleft()
            if self.agent is None:
                continue
            self._steps += 1
            assert self._steps < STEPS_PER_INSTANT, f"{self.agent.id} spins at {self.now_s} s"
            effects = self.agent.handle(event, self.now_s)
            self.busiest = max(self.busiest, len(effects))
            for effect in effects:
                self._carry_out(effect)

    def _carry_out(self, effect: Effect) -> None:
        self._watch(effect)
        if isinstance(effect, Commit):
            if effect.note is None:
                self.memory.pop(effect.name, None)
            else:
                self.memory[effect.name] = effect.note
        elif isinstance(effect, Instruct) and self.body is not None:
            self._queue.extend(map(Reported, self.body.instruct(effect.instruction, self.now_s)))
        elif isinstance(effect, Send) and (answer := plentiful.answer(effect.to, effect.message)):
            # Storages are always there, and have everything.
            self._queue.append(Received(effect.to, answer))
        elif isinstance(effect, Leave):
            self.agent = None


def said(effects: Iterable[Effect]) -> list[Message]:
    """All that was sent or published, in order."""
    return [effect.message for effect in effects if isinstance(effect, Send | Publish)]
