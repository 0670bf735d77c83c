"""What the central planner reserves: places for a time, and the lanes of a plan."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf


@dataclass(slots=True, eq=False)
class Visit:
    """A place, held by a vehicle for a time.

    Attributes:
        done: the vehicle has held it and is through.
    """

    place: str
    atv: str
    from_s: float
    until_s: float
    done: bool = False


class Step:
    """One lane of a plan."""

    __slots__ = ("arrive_s", "before", "end", "leave_s", "start", "until_s")

    def __init__(
        self, start: str, end: str, leave_s: float, arrive_s: float, until_s: float, before: Step | None
    ) -> None:
        self.start, self.end, self.before = start, end, before
        self.leave_s, self.arrive_s, self.until_s = leave_s, arrive_s, until_s


def free_spans(visits: list[Visit]) -> list[tuple[float, float]]:
    """The times between visits."""
    spans: list[tuple[float, float]] = []
    from_s = -inf
    for visit in sorted(visits, key=lambda one: one.from_s):
        if visit.from_s > from_s:
            spans.append((from_s, visit.from_s))
        from_s = max(from_s, visit.until_s)
    spans.append((from_s, inf))
    return spans
