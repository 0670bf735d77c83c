"""The reorder buffer: what was heard of a task before anybody had opened it."""

from __future__ import annotations

from collections import deque

from dray.messages import Event
from dray.messages.fact import GoalWaits

EARLY_KEPT = 512
"""Facts kept: some seconds of a plant of 1,000 vehicles."""


class ReorderBuffer:
    """The facts, the oldest first; when there are too many the oldest leaves."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=EARLY_KEPT)

    def keep(self, event: Event) -> None:
        """Keep a fact until its task is opened."""
        self._events.append(event)

    def take(self, task: str) -> list[Event]:
        """What was heard of a task that has been opened now; it is kept no longer."""
        taken = [event for event in self._events if task_of(event) == task]
        if taken:
            self._events = deque((event for event in self._events if event not in taken), maxlen=EARLY_KEPT)
        return taken


def task_of(event: Event) -> str:
    """The task that a fact is about, if any; a goal is the task that gives it out."""
    fact = event.fact
    name: str = fact.goal if isinstance(fact, GoalWaits) else getattr(fact, "task", "")
    return name
