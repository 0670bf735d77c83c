"""A factory's performance over some time, from its agents' history. Pure.

The history in the database is complete: the historian asks for every missed fact. So the counts here are exact, even for the
time of the historian's own absence. Times are the plant's.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping

import msgspec

from dray.messages import AnyFact, MachineHeartbeat, Reason, Role, Transport
from dray.messages.fact import CarrierChanged, ContractEnded, TaskClosed, TaskOpened
from dray.messages.keys import STRATEGISTS

WINDOW_S = 900.0
"""The window for a flow, in seconds: some fifteen transports of the default plant at its usual load. By chance alone one such
window may be a quarter worse than another; a shorter one would show only chance."""

KINDS = tuple(kind.__name__ for kind in (TaskOpened, TaskClosed, CarrierChanged, ContractEnded))
"""The facts that count here."""


class RecordedFact(msgspec.Struct, frozen=True):
    """A fact, its agent, and its time."""

    agent: str
    at_s: float
    fact: AnyFact


class History:
    """The outcome of the transports of some time.

    Args:
        told: the facts of that time, each once, by time.

    Attributes:
        delivered_s: the times of transports closed as delivered, in order.
        twice: transports closed as delivered twice, or handed over by two vehicles.
    """

    def __init__(self, told: Iterable[RecordedFact]) -> None:
        self.delivered_s: list[float] = []
        self.twice: set[str] = set()
        self._open: dict[str, tuple[str, float]] = {}
        """Open transports: the coordinator and the time of opening."""
        self._delivered: set[str] = set()
        self._carriers: dict[str, str] = {}
        """The vehicle that has handed over, by task."""
        self._changes: list[tuple[float, str]] = []
        """Replacements of carriers: the time and the former carrier."""
        for each in told:
            self._note(each)

    def lost(self, words: Mapping[str, MachineHeartbeat]) -> set[str]:
        """Open transports that their machine does not mention any more.

        Args:
            words: the newest heartbeat of each machine.
        """
        named = {machine: {brief.task for brief in word.tasks} for machine, word in words.items()}
        return {
            task
            for task, (machine, opened_s) in self._open.items()
            if machine in words and opened_s < words[machine].at_s and task not in named[machine]
        }

    def passed_on(self, carrier: str, from_s: float, to_s: float) -> int:
        """Number of a vehicle's tasks taken over by others, from one moment to another."""
        return sum(who == carrier and from_s <= at_s <= to_s for at_s, who in self._changes)

    def per_minute(self, from_s: float, to_s: float) -> float:
        """Transports delivered per minute, from one moment to another."""
        times = self.delivered_s
        count = bisect_right(times, to_s) - bisect_left(times, from_s)
        return 60.0 * count / (to_s - from_s) if to_s > from_s else 0.0

    def worst_per_minute(self, from_s: float, to_s: float) -> float:
        """The lowest rate of any `WINDOW_S` between two moments; the mean, if the time is shorter."""
        last_s = to_s - WINDOW_S
        if last_s <= from_s:
            return self.per_minute(from_s, to_s)
        times = self.delivered_s
        # The minimum is in a window that begins at the start, or just after a delivery.
        begins_s = [from_s, *(at_s for at_s in times if from_s <= at_s <= last_s)]
        fewest = min(bisect_left(times, at_s + WINDOW_S) - bisect_right(times, at_s) for at_s in begins_s)
        return 60.0 * fewest / WINDOW_S

    def _note(self, told: RecordedFact) -> None:
        fact = told.fact
        if isinstance(fact, TaskOpened):
            if fact.role is Role.PRIMARY and isinstance(fact.work, Transport):
                self._open.setdefault(fact.task, (told.agent, told.at_s))
        elif isinstance(fact, TaskClosed):
            self._note_closed(told.agent, fact, told.at_s)
        elif isinstance(fact, CarrierChanged):
            self._changes.append((told.at_s, fact.replaced))
        elif (
            isinstance(fact, ContractEnded)
            and fact.role is Role.PRIMARY
            and fact.reason == Reason.HANDED_OVER
        ):
            if self._carriers.setdefault(fact.task, told.agent) != told.agent:
                self.twice.add(fact.task)

    def _note_closed(self, coordinator: str, closed: TaskClosed, at_s: float) -> None:
        self._open.pop(closed.task, None)
        # The strategist closes goals, not transports.
        if closed.outcome != "delivered" or coordinator in STRATEGISTS:
            return
        if closed.task in self._delivered:
            self.twice.add(closed.task)
            return
        self._delivered.add(closed.task)
        self.delivered_s.append(at_s)
