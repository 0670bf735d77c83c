"""How an order's estimate moves, and why. Pure: decides what to store; `estimate_keeper` reads and writes.

An estimate has moved when one of its ends shifts by more than its rounding step (`tracking/eta.py`: one, five
or fifteen minutes). Smaller shifts are rounding. With several causes, the one that people can act on most is
given.
"""

from __future__ import annotations

import msgspec

from dray.gateway.factory.lateness import EXPLAINS_FRAC, Hold
from dray.gateway.tracking.eta import Range, step_s
from dray.gateway.tracking.reasons import Doing
from dray.store.orders.estimates import Estimate, EstimateCause

CLOCK_OFF_S = 1e-6
"""Tolerance for the difference of two large numbers, in seconds."""


class Since(msgspec.Struct, frozen=True, kw_only=True):
    """What has happened to an order since its last estimate; fields that do not apply are empty."""

    changed: bool = False
    """Whether people have changed it."""
    waits: bool = False
    """Whether no machine can make a part of it."""
    doings: dict[str, Doing] = {}
    """Activities of its machines, by name."""
    moved: tuple[str, str] | None = None
    """A machine that failed with a part of it, and its successor; empty if none yet."""
    hold: tuple[str, Hold] | None = None
    """The machine held up longest, and the cause."""
    passed: str = ""
    """An order that overtook it in a queue."""
    replaced: tuple[str, str] | None = None
    """A replaced carrier of its goods, and the successor; empty if none yet."""
    held_up: bool = False
    """Whether its goods are held up."""


def moved(before: Estimate | None, now: Range | None) -> bool:
    """Whether to store an estimate; nothing is stored before the first one."""
    known = _range(before)
    if known is None or now is None:
        return now is not known
    least_s = step_s(max(known.to_s - known.from_s, now.to_s - now.from_s)) + CLOCK_OFF_S
    return abs(now.from_s - known.from_s) > least_s or abs(now.to_s - known.to_s) > least_s


def estimate(before: Estimate | None, now: Range | None, since: Since, at_s: float) -> Estimate:
    """The record of an estimate that has moved.

    Args:
        before: the last stored one.
        now: the present estimate; None if there is none.
        since: events since.
        at_s: wall clock.
    """
    cause, agent, other = _cause(before, now, since)
    ends = (None, None) if now is None else (now.from_s, now.to_s)
    return Estimate(at_s=at_s, from_at_s=ends[0], to_at_s=ends[1], cause=cause, agent=agent, other=other)


def _range(kept: Estimate | None) -> Range | None:
    if kept is None or kept.from_at_s is None or kept.to_at_s is None:
        return None
    return Range(kept.from_at_s, kept.to_at_s)


Cause = tuple[EstimateCause, str, str]


def _cause(before: Estimate | None, now: Range | None, since: Since) -> Cause:
    known = _range(before)
    if now is None:
        return _why_not(since)
    if before is None:
        return "first", "", ""
    if since.changed:
        return "changed", "", ""
    if known is None:
        return ("again", "", "") if since.moved is None else ("moved", *since.moved)
    if now.to_s > known.to_s:
        return _why_later(now.to_s - known.to_s, since)
    return ("closer" if now.from_s >= known.from_s else "sooner"), "", ""


def _why_not(since: Since) -> Cause:
    """Why there is no estimate any more."""
    if since.waits:
        return "no_machine", "", ""
    broken = next((name for name, doing in since.doings.items() if doing is Doing.BROKEN), None)
    if broken is not None:
        return "stands", broken, ""
    silent = next((name for name, doing in since.doings.items() if doing is Doing.SILENT), None)
    return ("unknown", "", "") if silent is None else ("silent", silent, "")


def _why_later(by_s: float, since: Since) -> Cause:
    if since.moved is not None:
        return "moved", *since.moved
    if since.hold is not None and since.hold[1].lasted_s >= EXPLAINS_FRAC * by_s:
        machine, hold = since.hold
        kind: EstimateCause = {"starves": "material", "silent": "silent"}.get(hold.doing, "stands")  # type: ignore[assignment]
        return kind, machine, hold.by if kind == "material" else ""
    if since.passed:
        return "passed", "", since.passed
    if since.replaced is not None:
        return "replaced", *since.replaced
    return ("held_up" if since.held_up else "later"), "", ""
