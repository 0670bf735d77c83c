"""What held up a late carrier: its longest other activity, by its spells."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import msgspec

from dray.store.orders.tasks import TaskRow
from dray.store.replay.spells import Spell
from dray.store.work import Work

HOLDS = frozenset({"waits", "stopped", "blocked", "silent", "charges", "out", "starves", "broken"})
"""Activities that do not advance a vehicle's task or a machine's goal."""

EXPLAINS_FRAC = 0.25
"""Minimum length of a hold, as a fraction of the lateness, to be given as its cause."""

LATE_S = 1.0
"""Wall seconds of lateness below which no cause is sought."""


class Hold(msgspec.Struct, frozen=True, kw_only=True):
    """What held up a carrier."""

    doing: str
    """One of `HOLDS`, as in `/api/spells`."""
    by: str = ""
    """What it waited for longest, or what was wrong; empty if unknown."""
    lasted_s: float
    """Total wall seconds of that kind."""


class Span(NamedTuple):
    """The time in which a carrier had a task, wall clock."""

    task: str
    agent: str
    since_s: float
    until_s: float
    late_s: float
    """Wall seconds after its promise."""


def late_span(row: TaskRow, now_s: float) -> Span | None:
    """The time in which the carrier of a late task had it; None if it is not late, or unknown.

    Args:
        row: the task.
        now_s: wall clock, for an open task.
    """
    if row.promised_at_s is None or row.contracted_at_s is None or not row.carrier:
        return None
    until_s = now_s if row.closed_at_s is None else row.closed_at_s
    late_s = until_s - row.promised_at_s
    return Span(row.id, row.carrier, row.contracted_at_s, until_s, late_s) if late_s > LATE_S else None


async def holds_of(work: Work, rows: Iterable[TaskRow], now_s: float) -> dict[str, Hold]:
    """What held up the carriers of late tasks, by task.

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
    """What held up each span, if known. Pure.

    Args:
        spans: late transports.
        spells: their carriers' spells in any order; others are ignored.
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
        # Work for another task in that time did not hold up this one.
        if lasted_s > 0 and spell.task in ("", span.task):
            parts[spell.doing][spell.other] += lasted_s
    if not parts:
        return None
    doing, others = max(parts.items(), key=lambda part: (sum(part[1].values()), part[0]))
    by = max(others.items(), key=lambda part: (part[1], part[0]))[0]
    return Hold(doing=doing, by=by, lasted_s=sum(others.values()))
