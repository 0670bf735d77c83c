"""What a factory did over some time, from the history that its agents have told. Pure.

The history in the database is whole: the historian asks for every fact that it has missed. So what is counted
here is exact, also over the time in which the historian itself was away. Times are the plant's.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping

import msgspec

from dray.messages import AnyFact, MachineHeartbeat, Reason, Role, Transport
from dray.messages.fact import CarrierChanged, ContractEnded, TaskClosed, TaskOpened
from dray.messages.keys import STRATEGISTS

WINDOW_S = 900.0
"""Over which a flow is measured: some fifteen transports of the default plant at its usual load. Chance alone
makes one such window a quarter worse than another; a shorter one would tell of nothing else."""

KINDS = tuple(kind.__name__ for kind in (TaskOpened, TaskClosed, CarrierChanged, ContractEnded))
"""Of the facts that count here."""


class Told(msgspec.Struct, frozen=True):
    """A fact, who has told it, and when it was so."""

    agent: str
    at_s: float
    fact: AnyFact


class History:
    """What has become of the transports of some time.

    Args:
        told: the facts of that time, each once, in the order in which things happened.

    Attributes:
        delivered_s: when transports were closed as delivered, in order.
        twice: those that were closed as delivered twice, or handed over by two vehicles.
    """

    def __init__(self, told: Iterable[Told]) -> None:
        self.delivered_s: list[float] = []
        self.twice: set[str] = set()
        self._open: dict[str, tuple[str, float]] = {}
        """Transports that were opened and not closed: by whom, and when."""
        self._delivered: set[str] = set()
        self._carriers: dict[str, str] = {}
        """Who has handed over, by task."""
        self._changes: list[tuple[float, str]] = []
        """When a carrier was replaced, and who it was."""
        for each in told:
            self._note(each)

    def lost(self, words: Mapping[str, MachineHeartbeat]) -> set[str]:
        """Transports that are open, and that their machine has not named since.

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
        """How many tasks of a vehicle somebody else has carried on, from one moment to another."""
        return sum(who == carrier and from_s <= at_s <= to_s for at_s, who in self._changes)

    def per_minute(self, from_s: float, to_s: float) -> float:
        """Transports delivered per minute, from one moment to another."""
        times = self.delivered_s
        count = bisect_right(times, to_s) - bisect_left(times, from_s)
        return 60.0 * count / (to_s - from_s) if to_s > from_s else 0.0

    def worst_per_minute(self, from_s: float, to_s: float) -> float:
        """The same in the worst `WINDOW_S` between two moments; the whole, if they are nearer to each other."""
        last_s = to_s - WINDOW_S
        if last_s <= from_s:
            return self.per_minute(from_s, to_s)
        times = self.delivered_s
        # A window has the fewest where it begins at the start, or just after a delivery.
        begins_s = [from_s, *(at_s for at_s in times if from_s <= at_s <= last_s)]
        fewest = min(bisect_left(times, at_s + WINDOW_S) - bisect_right(times, at_s) for at_s in begins_s)
        return 60.0 * fewest / WINDOW_S

    def _note(self, told: Told) -> None:
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
