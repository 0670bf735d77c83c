"""When a machine's goals will be done, as promised, and moved when the goals before one of them change, or its speed is set.

A bid promises a finish after all more urgent goals that the machine has then. Later ones may come, and others are
withdrawn, given back, or changed. Then the machine computes the promises of all goals behind the change anew, and
tells those that have moved by more than `MOVES_S` and `MOVES_FRAC`. When a person sets its speed, it does so for all
its goals. A machine that is slow by itself, starved or broken moves no promise by that: it is late, and is shown as
late.
"""

from __future__ import annotations

from typing import NamedTuple

from dray.messages.fact import PromiseMoved
from dray.protocol.machine.production import REST_MAX_S, Goal, GoalBook
from dray.protocol.machine.products import at_hand
from dray.protocol.machine.supply import Supply
from dray.protocol.runtime.life import Life

MOVES_S = 60.0
"""Least move of a promise (s): as late as a machine may be against its bid when it takes an award."""

MOVES_FRAC = 0.05
"""Least move as a fraction of the time left, so that one goal does not move the promises of weeks."""

_Key = tuple[float, str]


class _Seen(NamedTuple):
    """A confirmed goal at the last review."""

    goal: Goal
    key: _Key
    quantity: int
    at_work: bool


class Promises:
    """The promises of one machine.

    Args:
        goals: its goals.
        supply: its stock and lead times.
        life: the agent's life.
    """

    def __init__(self, goals: GoalBook, supply: Supply, life: Life) -> None:
        self._goals = goals
        self._supply = supply
        self._life = life
        self._speed_frac = goals.speed_frac
        """The set speed at the last review."""
        self._seen: dict[str, _Seen] = {}
        """By goal; as many as the machine has."""

    def note(self) -> None:
        """Take the present goals and speed as known, without moving a promise: an earlier life has done so."""
        self._speed_frac = self._goals.speed_frac
        self._seen = {
            goal.id: _Seen(goal, (goal.deadline_s, goal.id), goal.work.quantity, goal.given_back_s is None)
            for goal in self._goals.confirmed()
        }

    def review(self, now_s: float) -> None:
        """Move the promises behind a change of the goals since the last review, or all after a change of the set speed."""
        before, speed_frac = self._seen, self._speed_frac
        self.note()
        changes = _changes(before, self._seen)
        if self._speed_frac != speed_frac:
            changes += [each.key for each in self._seen.values()]
        first = min(changes, default=None)
        if first is None:
            return
        came = [each for each in self._seen.values() if _came(before.get(each.goal.id), each)]
        queue_s = 0.0
        is_news = False
        moved = []
        for goal in self._goals.at_work():
            own_s = max(0, goal.to_make) * self._goals.cycle_s(goal.work)
            seen, known = self._seen[goal.id], before.get(goal.id)
            # A new goal has just been promised.
            if known is not None and seen.key >= first and own_s > 0.0:
                others = self._seen.values() if seen.key > known.key else came
                news = sum(_passed(before.get(each.goal.id), each, known, seen) for each in others)
                goal.came_before += news
                is_news |= news > 0
                if self._move(goal, self._finish_s(goal, queue_s, own_s, now_s), now_s):
                    moved.append(PromiseMoved(goal.id, goal.promised_s, goal.came_before))
            queue_s += own_s
        if is_news or moved:
            self._life.commit()
        for fact in moved:
            self._life.record(fact)

    def _finish_s(self, goal: Goal, queue_s: float, own_s: float, now_s: float) -> float:
        """When a goal is done after so much other work, as a quote counts it."""
        lead_s = 0.0 if at_hand(goal.work, self._supply.stock) else self._supply.longest_lead_s(goal.work)
        works_s = max(queue_s, lead_s) + own_s
        return now_s + works_s + min(self._goals.working_time.rests_s(now_s, works_s), REST_MAX_S)

    def _move(self, goal: Goal, finish_s: float, now_s: float) -> bool:
        by_s = abs(finish_s - goal.promised_s)
        if goal.promised_s <= 0.0 or by_s <= max(MOVES_S, MOVES_FRAC * (finish_s - now_s)):
            return False
        goal.promised_s = finish_s
        return True


def _changes(before: dict[str, _Seen], after: dict[str, _Seen]) -> list[_Key]:
    """The places at which goals have come, gone or changed. A goal that was made has not gone before its time."""
    gone = [each.key for name, each in before.items() if name not in after and each.goal.to_make > 0]
    changed = [
        min(each.key, known.key) if known is not None else each.key
        for name, each in after.items()
        if (known := before.get(name)) != each
    ]
    return gone + changed


def _came(known: _Seen | None, seen: _Seen) -> bool:
    """Whether a goal is new, or more urgent than before."""
    return seen.at_work and (known is None or seen.key < known.key)


def _passed(was: _Seen | None, now: _Seen, other_was: _Seen, other: _Seen) -> bool:
    """Whether a goal stands before another one now and did not before."""
    return now.at_work and now.key < other.key and (was is None or was.key > other_was.key)
