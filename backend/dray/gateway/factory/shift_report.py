"""The report on a shift: the outcome of any span of time, against the shift before and against targets.

It is computed from sums in SQL: minute figures, orders, spells of vehicles and machines, takeovers in agents'
histories, and the audit log. The last minute and unwritten data are missing, except present spells. An
unknown figure is null, never 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import msgspec

from dray.gateway.factory.figures import KpiPoint, part
from dray.store.replay.spells import Spell
from dray.store.shifts import LateOrder

Better = Literal["more", "less"]


class Figure(msgspec.Struct, frozen=True, gc=False):
    """A figure of the report."""

    unit: str
    """count, frac, Wh, or s (factory seconds)."""
    better: Better
    """Which values are good: a target is the minimum (more) or maximum (less)."""


FIGURES: Mapping[str, Figure] = {
    "orders_delivered": Figure("count", "more"),
    "on_time_frac": Figure("frac", "more"),
    "orders_late": Figure("count", "less"),
    "orders_open": Figure("count", "less"),
    "orders_overdue": Figure("count", "less"),
    "transports": Figure("count", "more"),
    "transport_p50_s": Figure("s", "less"),
    "transport_p95_s": Figure("s", "less"),
    "empty_frac": Figure("frac", "less"),
    "starved_frac": Figure("frac", "less"),
    "machine_producing_frac": Figure("frac", "more"),
    "machine_available_frac": Figure("frac", "more"),
    "atv_available_frac": Figure("frac", "more"),
    "waits": Figure("count", "less"),
    "waited_frac": Figure("frac", "less"),
    "energy_wh": Figure("Wh", "less"),
    "transport_energy_wh": Figure("Wh", "less"),
    "interventions": Figure("count", "less"),
    "helps": Figure("count", "less"),
    "takeovers": Figure("count", "less"),
}
"""In the order of the report."""


class ReportFigure(msgspec.Struct, frozen=True, kw_only=True):
    """One figure of a shift. None for an unknown value or target."""

    name: str
    unit: str
    better: str
    """more or less."""
    value: float | None
    before: float | None
    """Value of the compared shift. None if unknown, and for a count of 0 of a span in which no gateway counted."""
    target: float | None
    missed: bool
    """Whether there is a target and the value is worse."""


class AgentShift(msgspec.Struct, frozen=True, kw_only=True):
    """The activities of one vehicle or machine in a shift."""

    agent: str
    kind: str
    """atv or machine."""
    areas: tuple[str, ...]
    """For a machine: ids of its areas."""
    doings_s: dict[str, float]
    """Wall seconds per activity, in the words of `GET /api/spells`."""
    waits: int
    """Number of waits for others."""


class AreaShift(msgspec.Struct, frozen=True, kw_only=True):
    """The activity in one area."""

    area: str
    name: str
    machines: int
    starved_frac: float | None
    """Starving fraction of its machines' time spent making or starving."""
    passes: int
    """Passages of its lanes; like the two below, for the wall hours that begin in the shift."""
    waits: int
    """Number of times that a vehicle came to a stand on them."""
    waited_s: float
    """Factory seconds."""


class TakeoverLine(msgspec.Struct, frozen=True, kw_only=True):
    """A takeover of a transport."""

    at_s: float
    task: str
    replaced: str
    carrier: str
    reason: str
    """A `Reason`."""
    silent_s: float


class InterventionLine(msgspec.Struct, frozen=True, kw_only=True):
    """A person's intervention, by role only, since many people read a report."""

    at_s: float
    action: str
    role: str
    target: str
    command: str
    """Kind of a command to a vehicle; else empty."""


class Period(msgspec.Struct, frozen=True, kw_only=True):
    """A span of time, and how much of it is known."""

    from_at_s: float
    until_at_s: float
    """At most now."""
    seen_frac: float
    """Fraction in which a gateway counted: below 1, counts are too low."""


class ShiftReport(msgspec.Struct, frozen=True, kw_only=True):
    """The report on a shift."""

    plant: str
    made_at_s: float
    period: Period
    before: Period
    """The span compared with."""
    figures: tuple[ReportFigure, ...]
    course: tuple[KpiPoint, ...]
    """Oldest first, in equal steps."""
    step_s: float
    """Wall seconds of a step of `course`."""
    agents: tuple[AgentShift, ...]
    areas: tuple[AreaShift, ...]
    takeovers: tuple[TakeoverLine, ...]
    """The last 50 at most, like the interventions."""
    interventions: tuple[InterventionLine, ...]
    """Empty for callers who may not read the audit log."""
    waits: tuple[Spell, ...]
    """The ten longest, longest first; `other` is what each waited for."""
    late_orders: tuple[LateOrder, ...]
    """The twenty latest; empty for callers who may not read orders."""


def figures_of(
    now: Mapping[str, float | None], before: Mapping[str, float | None], targets: Mapping[str, float]
) -> tuple[ReportFigure, ...]:
    """All figures of a shift with those of the one before, and their targets."""
    return tuple(
        ReportFigure(
            name=name,
            unit=figure.unit,
            better=figure.better,
            value=now.get(name),
            before=before.get(name),
            target=targets.get(name),
            missed=_is_missed(figure.better, now.get(name), targets.get(name)),
        )
        for name, figure in FIGURES.items()
    )


def _is_missed(better: str, value: float | None, target: float | None) -> bool:
    if value is None or target is None:
        return False
    return value < target if better == "more" else value > target


def agents_of(
    uses: Sequence[tuple[str, str, float, int]],
    machines: Mapping[str, tuple[str, ...]],
    atvs: Sequence[str],
) -> tuple[AgentShift, ...]:
    """The activities joined per agent.

    Args:
        uses: agent, activity, wall seconds, count.
        machines: the plant's machines with their areas.
        atvs: its vehicles; an unknown agent with a machine's activities is a machine.
    """
    found: dict[str, tuple[dict[str, float], list[int]]] = {}
    for agent, doing, spent_s, count in uses:
        doings_s, waits = found.setdefault(agent, ({}, [0]))
        doings_s[doing] = doings_s.get(doing, 0.0) + spent_s
        waits[0] += count if doing == "waits" else 0
    return tuple(
        AgentShift(
            agent=agent,
            kind="machine"
            if agent in machines or (agent not in atvs and _OF_MACHINES & doings_s.keys())
            else "atv",
            areas=machines.get(agent, ()),
            doings_s={doing: round(spent_s, 3) for doing, spent_s in doings_s.items()},
            waits=waits[0],
        )
        for agent, (doings_s, waits) in sorted(found.items())
    )


_OF_MACHINES = {"makes", "starves", "broken"}


def starved_frac(agents: Sequence[AgentShift]) -> float | None:
    """Fraction of these machines' time with work in which they starved."""
    made_s, starved_s = (
        sum(each.doings_s.get(doing, 0.0) for each in agents) for doing in ("makes", "starves")
    )
    return part(starved_s, made_s + starved_s)


def waited(agents: Sequence[AgentShift]) -> tuple[int | None, float | None]:
    """Number of vehicles' waits, and their fraction of the time; None if unknown."""
    atvs = [each for each in agents if each.kind == "atv"]
    all_s = sum(spent_s for each in atvs for doing, spent_s in each.doings_s.items() if doing != "out")
    waits_s = sum(each.doings_s.get("waits", 0.0) for each in atvs)
    return (sum(each.waits for each in atvs) if atvs else None), part(waits_s, all_s)
