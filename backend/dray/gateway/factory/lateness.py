"""What held up a carrier that came later than it had promised: the longest of what it did instead, as spells tell it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import msgspec

from dray.store.orders.tasks import TaskRow
from dray.store.replay.spells import Spell
from dray.store.work import Work

HOLDS = frozenset({"waits", "stopped", "blocked", "silent", "charges", "out", "starves", "broken"})
"""What a vehicle with a task, or a machine with a goal, does that brings it no nearer."""

EXPLAINS_FRAC = 0.25
"""Least part of the lateness that a hold has to be as long as to be told as its cause."""

LATE_S = 1.0
"""Wall seconds below which nobody asks why."""


class Hold(msgspec.Struct, frozen=True, kw_only=True):
    """What held a carrier up."""

    doing: str
    """As in `/api/spells`: one of `HOLDS`."""
    by: str = ""
    """For whom or what it waited longest, or what was wrong; empty where nobody knows."""
    lasted_s: float
    """Wall seconds of all of that kind together."""


class Span(NamedTuple):
    """When a carrier had a task. Wall clock."""

    task: str
    agent: str
    since_s: float
    until_s: float
    late_s: float
    """Wall seconds after its promise."""


def late_span(row: TaskRow, now_s: float) -> Span | None:
    """When the carrier of a late task had it; None of one that is as promised, or of which that is not known.

    Args:
        row: the task.
        now_s: wall clock, for one that has not ended.
    """
    if row.promised_at_s is None or row.contracted_at_s is None or not row.carrier:
        return None
    until_s = now_s if row.closed_at_s is None else row.closed_at_s
    late_s = until_s - row.promised_at_s
    return Span(row.id, row.carrier, row.contracted_at_s, until_s, late_s) if late_s > LATE_S else None


async def holds_of(work: Work, rows: Iterable[TaskRow], now_s: float) -> dict[str, Hold]:
    """What held up the carriers of those that were late, by task.

    Args:
        work: an open transaction.
        rows: tasks.
        now_s: wall clock.
    """
    spans = [span for row in rows if (span := late_span(row, now_s)) is not None]
    if not spans:
        return {}
    asked = [(span.agent, span.since_s, span.until_s) for span in spans]
    return held(spans, await work.spells.of_spans(asked, sorted(HOLDS)))


def held(spans: Sequence[Span], spells: Iterable[Spell]) -> dict[str, Hold]:
    """The cause of each that has one. Pure.

    Args:
        spans: late transports.
        spells: of their carriers, in any order; others are left out.
    """
    by_agent: dict[str, list[Spell]] = defaultdict(list)
    for spell in spells:
        if spell.doing in HOLDS:
            by_agent[spell.agent].append(spell)
    found = {}
    for span in spans:
        hold = _longest(span, by_agent[span.agent])
        if hold is not None and hold.lasted_s >= EXPLAINS_FRAC * span.late_s:
            found[span.task] = hold
    return found


def _longest(span: Span, spells: Iterable[Spell]) -> Hold | None:
    parts: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
    for spell in spells:
        lasted_s = min(spell.until_at_s, span.until_s) - max(spell.from_at_s, span.since_s)
        # What it did for another task in the same time is not what held up this one.
        if lasted_s > 0 and spell.task in ("", span.task):
            parts[spell.doing][spell.other] += lasted_s
    if not parts:
        return None
    doing, others = max(parts.items(), key=lambda part: (sum(part[1].values()), part[0]))
    by = max(others.items(), key=lambda part: (part[1], part[0]))[0]
    return Hold(doing=doing, by=by, lasted_s=sum(others.values()))
