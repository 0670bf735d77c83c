"""When an order will arrive: a range, or nothing if no estimate is possible. Pure arithmetic.

Method. Each running goal gets a range of its own, from the best evidence there is:

1. *All pieces made.* Only the way to the delivery warehouse is left: the time of the last piece, plus what
   nine of ten of the factory's last transports took, and one of ten (p10 and p90).
2. *Some pieces made* (`PIECES_NEEDED` or more). With `m` and `s` the mean and the standard deviation of
   the last `n` gaps between pieces, `k` more pieces take `k m ± Z s sqrt(k + k²/n)`: the first term
   is chance in each gap, the second how little `n` gaps tell of the mean. All of that is working time
   of the machine, and ends when so much of it has passed. The way is added as above.
3. *Too few pieces.* What the machine promised when it took the goal, its queue included, moved by what
   the last finished goals missed their first promises by (p10 to p90). With fewer than `PROMISES_NEEDED` of those,
   the range reaches from the promise to half the time till then later. So it does from a promise that the machine
   has moved since, because what goals miss their first promises by includes such moves. The end of the machine's
   present work for more urgent goals and for this one counts instead, if that is later: small moves are not told.

The order's range ends with the latest of its goals, since it is delivered when all are. An open gap counts as
a gap, so a halt moves the range. A range overtaken by the clock extends beyond now by its present lateness.
There is no range if no machine has taken missing pieces, or if a machine concerned is broken or silent.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, isfinite, sqrt
from statistics import fmean, stdev
from typing import Protocol

import msgspec

from dray.plant.working_time import WorkingTime

PIECES_NEEDED = 5
"""Minimum pieces from which a machine's pace is better evidence than its promise: four gaps."""

GAPS_USED = 20
"""Maximum gaps used for a pace: the last ones, since material and wear change it."""

PROMISES_NEEDED = 8
"""Minimum finished goals for meaningful p10 and p90."""

Z = 2.0
"""Standard deviations each way: they cover 19 of 20 where the pace is well known, and nine of ten where few
gaps give a rough deviation."""

UNPROVEN_FRAC = 0.5
"""Maximum lateness of a promise as a fraction of the remaining time, without a history of such promises."""

STEPS_S = ((600.0, 60.0), (7200.0, 300.0), (float("inf"), 900.0))
"""Longest range, and its rounding step: no false precision."""


class Range(msgspec.Struct, frozen=True):
    """A range of wall clock seconds."""

    from_s: float
    to_s: float


class Working(Protocol):
    """A machine's working time, in wall clock seconds."""

    def between_s(self, start_s: float, end_s: float) -> float:
        """Working time between two moments."""
        ...

    def after_s(self, start_s: float, work_s: float) -> float:
        """The moment when so much working time has passed; infinite for never."""
        ...


ALWAYS = WorkingTime(None)


class Running(msgspec.Struct, frozen=True):
    """A goal in work. Times are wall clock seconds."""

    quantity: int
    made: int
    promised_at_s: float | None = None
    """The promise that holds now."""
    is_moved: bool = False
    """Whether its machine has moved that promise since it took the goal."""
    piece_times_s: tuple[float, ...] = ()
    """Times of its last pieces, oldest first."""
    working: Working = ALWAYS
    """Working time of its machine."""
    ahead_s: float = 0.0
    """Work of its machine until all of it is made, more urgent goals included; 0 if unknown, or if there are none."""


class History(msgspec.Struct, frozen=True):
    """The factory's recent performance. Wall clock seconds."""

    missed_by_s: tuple[float, ...] = ()
    """Lateness of finished goals against their first promises, ascending; negative if early."""
    way_s: tuple[float, float] | None = None
    """Durations of transports: p10 and p90; None before the first one."""


def eta(goals: Sequence[Running], history: History, now_s: float) -> Range | None:
    """When all these goals will have arrived.

    Args:
        goals: the goals with outstanding pieces; together they are all that is missing.
        history: the factory's recent performance.
        now_s: wall clock.

    Returns:
        None without goals, or if one of them allows no estimate.
    """
    ranges = [_of_goal(goal, history, now_s) for goal in goals]
    known = [each for each in ranges if each is not None]
    if not known or len(known) < len(ranges):
        return None
    return _ahead(Range(max(r.from_s for r in known), max(r.to_s for r in known)), now_s)


def step_s(width_s: float) -> float:
    """The rounding step for a range of this width, in seconds."""
    return next(step for longest, step in STEPS_S if width_s <= longest)


def rounded(exact: Range) -> Range:
    """The range rounded outwards to whole steps, so that it never becomes narrower."""
    step = step_s(exact.to_s - exact.from_s)
    return Range(exact.from_s // step * step, ceil(exact.to_s / step) * step)


def quantile(ascending: Sequence[float], part: float) -> float:
    """The nearest rank: always a real value."""
    return ascending[min(len(ascending) - 1, max(0, ceil(part * len(ascending)) - 1))]


def _of_goal(goal: Running, history: History, now_s: float) -> Range | None:
    if goal.made >= goal.quantity and goal.piece_times_s and history.way_s is not None:
        return _then_way(Range(goal.piece_times_s[-1], goal.piece_times_s[-1]), history.way_s)
    if goal.made < goal.quantity and len(goal.piece_times_s) >= PIECES_NEEDED:
        made = _by_pace(goal.piece_times_s, goal.quantity - goal.made, now_s, goal.working)
        if made is None:
            return None
        # Without any transport so far, assume a way of at most a fraction of the rest.
        way_s = history.way_s or (0.0, UNPROVEN_FRAC * (made.to_s - now_s))
        return _then_way(made, way_s)
    if goal.promised_at_s is None:
        return None
    promised_s = goal.promised_at_s
    if goal.ahead_s > 0.0:
        promised_s = max(promised_s, goal.working.after_s(now_s, goal.ahead_s))
    missed_by_s = () if goal.is_moved else history.missed_by_s
    return _by_promise(promised_s, missed_by_s, now_s) if isfinite(promised_s) else None


def _by_pace(piece_times_s: Sequence[float], left: int, now_s: float, working: Working) -> Range | None:
    """The range by pace.

    None for a machine that never works again, or whose working time differs from the known one.
    """
    times = piece_times_s[-GAPS_USED - 1 :]
    gaps_s = [working.between_s(earlier, later) for earlier, later in pairwise(times)]
    mean_s = fmean(gaps_s)
    if mean_s <= 0.0:
        return None
    # A gap longer than usual is still open: the rest begins now at the earliest.
    halted_s = max(0.0, working.between_s(times[-1], now_s) - mean_s)
    spread_s = Z * stdev(gaps_s) * sqrt(left + left * left / len(gaps_s))
    soonest_s = halted_s + max(0.0, left * mean_s - spread_s)
    latest_s = halted_s + left * mean_s + spread_s + halted_s
    found = Range(working.after_s(times[-1], soonest_s), working.after_s(times[-1], latest_s))
    return found if isfinite(found.to_s) else None


def _by_promise(promised_at_s: float, missed_by_s: Sequence[float], now_s: float) -> Range:
    if len(missed_by_s) >= PROMISES_NEEDED:
        low_s, high_s = quantile(missed_by_s, 0.1), quantile(missed_by_s, 0.9)
    else:
        low_s, high_s = 0.0, UNPROVEN_FRAC * max(0.0, promised_at_s - now_s)
    return Range(promised_at_s + low_s, promised_at_s + high_s)


def _then_way(made: Range, way_s: tuple[float, float]) -> Range:
    return Range(made.from_s + way_s[0], made.to_s + way_s[1])


def _ahead(found: Range, now_s: float) -> Range:
    """A range not before now: one that the clock has overtaken extends by its lateness."""
    overtaken_s = now_s - found.to_s
    return Range(max(found.from_s, now_s), found.to_s if overtaken_s < 0 else now_s + overtaken_s)
