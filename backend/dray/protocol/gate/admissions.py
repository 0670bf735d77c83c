"""The goals at the gate: admitted and arrived pieces of each, and the strategist that has to hear of them."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec.structs import replace

from dray.memory import GateGoal, Memory
from dray.messages import Brought
from dray.protocol.runtime.events import Commit

KEPT_GOALS = 4096
"""Maximum remembered goals. The large plant works on some hundred at a time and closes thousands in a day. So a finished
goal is remembered for hours, and goods are on the road for minutes."""


class Admissions:
    """The goals of one gate, the longest unchanged first.

    Invariant: the count of a goal never falls. A full memory forgets the goal that was unchanged longest, a
        finished one first, and
    among these one whose count was acknowledged.

    Args:
        kept: maximum number of remembered goals.
    """

    def __init__(self, kept: int = KEPT_GOALS) -> None:
        self._kept = kept
        self._goals: dict[str, GateGoal] = {}
        self._unwritten: dict[str, None] = {}

    def __iter__(self) -> Iterator[GateGoal]:
        return iter(list(self._goals.values()))

    def get(self, goal: str) -> GateGoal | None:
        """The record of a goal."""
        return self._goals.get(goal)

    def restore(self, memory: Memory) -> None:
        """Restore the notes of earlier lives."""
        for note in memory.values():
            if isinstance(note, GateGoal):
                self._goals[note.goal] = note

    def commits(self) -> list[Commit]:
        """The changes since the last call."""
        commits = [Commit(self._goals.get(goal), f"{goal} at the gate") for goal in self._unwritten]
        self._unwritten.clear()
        return commits

    def put(self, goal: GateGoal) -> None:
        """Store a new or changed goal."""
        self._goals.pop(goal.goal, None)
        self._goals[goal.goal] = goal
        self._unwritten[goal.goal] = None
        if len(self._goals) > self._kept:
            self._forget_one()

    def count(self, goal: GateGoal, arrived: int, vehicle: str) -> GateGoal:
        """Note a higher count of a goal; returns the changed goal."""
        brought = {each.vehicle: each.pieces for each in goal.brought}
        if vehicle:
            brought[vehicle] = brought.get(vehicle, 0) + arrived - goal.arrived
        counted = replace(
            goal, arrived=arrived, brought=tuple(Brought(who, pieces) for who, pieces in brought.items())
        )
        self.put(counted)
        return counted

    def of_order(self, order: str) -> tuple[GateGoal, ...]:
        """The goals of an order."""
        return tuple(goal for goal in self._goals.values() if goal.of is not None and goal.of.order == order)

    def _forget_one(self) -> None:
        quietest = next(iter(self._goals))
        finished = [goal for goal in self._goals.values() if goal.arrived >= goal.admitted]
        heard = (goal.goal for goal in finished if goal.heard >= goal.arrived)
        forgotten = next(heard, finished[0].goal if finished else quietest)
        del self._goals[forgotten]
        self._unwritten[forgotten] = None
