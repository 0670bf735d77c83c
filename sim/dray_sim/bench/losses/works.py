"""The course of tasks and goals, from the facts about them. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from dray.messages import Event, Transport
from dray.messages.fact import TaskClosed, TaskOpened


@dataclass(slots=True)
class Span:
    """Times of one transport's first announcement and of its delivery (plant clock)."""

    opened_s: float
    delivered_s: float | None = None

    @property
    def took_s(self) -> float | None:
        """Duration (s); None if the transport was not delivered."""
        return None if self.delivered_s is None else self.delivered_s - self.opened_s


class Works:
    """The course of every transport and goal.

    Args:
        events: all facts, in the order of time.

    Attributes:
        transports: the times of each transport, by task.
    """

    def __init__(self, events: Iterable[Event]) -> None:
        self.transports: dict[str, Span] = {}
        self._about: dict[str, list[Event]] = {}
        for event in events:
            fact = event.fact
            work = getattr(fact, "task", "") or getattr(fact, "goal", "")
            if work:
                self._about.setdefault(work, []).append(event)
            if isinstance(fact, TaskOpened) and isinstance(fact.work, Transport):
                self.transports.setdefault(fact.task, Span(event.at_s))
            elif (
                isinstance(fact, TaskClosed) and fact.outcome == "delivered" and fact.task in self.transports
            ):
                self.transports[fact.task].delivered_s = event.at_s

    def after(self, work: str, at_s: float) -> Sequence[Event]:
        """Events of a task or a goal after this moment (plant clock)."""
        return [event for event in self._about.get(work, ()) if event.at_s > at_s]

    def durations_s(self, since_s: float, until_s: float) -> list[float]:
        """Duration of each transport that was delivered in this span (plant clock)."""
        return [
            span.delivered_s - span.opened_s
            for span in self.transports.values()
            if span.delivered_s is not None and since_s <= span.delivered_s < until_s
        ]
