"""The figures of vehicles that pass through one another, beside those of vehicles that take up room."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from dray_sim.run.evidence import Evidence, Table
from dray_sim.run.report import Report
from dray_sim.run.scenario import Outcome
from dray_sim.run.site import Site
from dray_sim.scenarios import SCENARIOS

COMPARED = ("day", "case-4", "case-5", "experiment-wlan", "experiment-power-off")
"""Played a second time for the document: those that take seconds."""

TITLE = "What vehicles that pass through one another would promise"

FIGURES: dict[str, Callable[[Report], str]] = {
    "orders delivered": lambda report: f"{report.orders_delivered} of {report.orders_placed}",
    "orders on time": lambda report: f"{report.on_time_frac:.1%}",
    "transports": lambda report: str(report.transports),
    "transport p50": lambda report: f"{report.transport_p50_s:.0f} s",
    "transport p95": lambda report: f"{report.transport_p95_s:.0f} s",
    "later than promised p95": lambda report: f"{report.late_p95_s:+.1f} s",
    "machines starving": lambda report: f"{report.starvation_frac:.2%} of their time with work",
}
"""Figures of a report that traffic changes."""


def compared(name: str, seed: int, site: Site, outcome: Outcome) -> Table | None:
    """Play a scenario again without right of way, and put its figures beside those with it.

    Args:
        name: of the scenario.
        seed: of both runs.
        site: where the first run was played.
        outcome: of the first run.

    Returns:
        None where there is nothing to compare: the first run was also without right of way, or takes long, or all
            figures are equal.
    """
    if not site.traffic or name not in COMPARED:
        return None
    alone = SCENARIOS[name].run(seed, replace(site, traffic=False))
    rows = tuple(row for row in _rows(outcome, alone) if row[1] != row[2])
    return Table(TITLE, ("", "true", "as ghosts"), rows) if rows else None


def _rows(outcome: Outcome, alone: Outcome) -> list[tuple[str, str, str]]:
    if isinstance(outcome, Report) and isinstance(alone, Report):
        return [(name, figure(outcome), figure(alone)) for name, figure in FIGURES.items()]
    if isinstance(outcome, Evidence) and isinstance(alone, Evidence):
        seen = {check.name: check.figure for check in alone.checks}
        return [
            (check.name, check.figure, seen[check.name]) for check in outcome.checks if check.name in seen
        ]
    return []
