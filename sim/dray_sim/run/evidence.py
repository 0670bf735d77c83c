"""The evidence of a scenario: a claim, and the checks on which it rests, each with its figure.

Evidence is data first (`--json`), and readable in two forms: lines for a terminal, and a section of
docs/scenarios.md. Every check states an observation of a run; none is written down before.
"""

from __future__ import annotations

from textwrap import wrap

import msgspec

from dray_sim.run.verdict import Verdict

HELD = "held"
"""Text for the invariants of a report when all held."""

LINE = 100
"""Columns of running text."""


FIGURES = (
    "orders_placed",
    "orders_delivered",
    "orders_due",
    "on_time_frac",
    "starvation_frac",
    "transport_p50_s",
    "transport_p95_s",
)
"""Names of the figures of one run, as in its `dray_sim.run.report.Report`."""


class Check(msgspec.Struct, frozen=True):
    """One condition of the claim."""

    name: str
    """The condition, as a sentence."""
    held: bool
    figure: str
    """The observation."""


class Table(msgspec.Struct, frozen=True):
    """Figures side by side; the first row is the one to compare with, where there is one."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def document(self) -> str:
        """The table in a Markdown document."""
        lines = [f"{self.title}:", "", _row(self.head), _row(("---",) * len(self.head))]
        return "\n".join((*lines, *map(_row, self.rows)))


class Evidence(msgspec.Struct, frozen=True):
    """The report of a scenario."""

    scenario: str
    seed: int
    source: str
    """Source of the claim in the paper, or a note that it is ours."""
    claim: str
    story: str
    """The events in the factory."""
    held: bool
    """The claim, and every invariant of every run."""
    checks: tuple[Check, ...]
    tables: tuple[Table, ...]
    measured: dict[str, str]
    """Figures that depend on the computer: real time and memory. They are not part of the document."""
    invariants: str
    """`held`, or the first broken invariant."""
    trace: str
    """The fingerprint of all messages, in all runs."""
    orders_placed: int = 0
    """From here on: figures of the run in which the fewest orders were on time."""
    orders_delivered: int = 0
    orders_due: int = 0
    on_time_frac: float = 0.0
    starvation_frac: float = 0.0
    transport_p50_s: float = 0.0
    transport_p95_s: float = 0.0
    verdict: Verdict | None = None
    """The bottleneck of that run."""

    def describe(self) -> str:
        """The report for a terminal; except for `measured`, the same bytes for the same seed."""
        lines = [
            f"{self.scenario}, seed {self.seed}: {self._verdict()}",
            "",
            *wrap(f"Claim ({self.source}): {self.claim}", LINE),
            *wrap(f"Done: {self.story}", LINE),
            "",
            *(line for check in self.checks for line in _check_lines(check)),
        ]
        for each in self.tables:
            lines += ["", f"  {each.title}", *_columns(each)]
        lines.append("")
        lines += [f"  {name:<14} {value}" for name, value in self._last_lines().items()]
        return "\n".join(lines)

    def document(self) -> str:
        """The report as a section of a Markdown document; the same bytes for the same seed.

        Without the trace, which any new word of any agent changes: the document is about figures.
        """
        lines = [
            f"## {self.scenario}",
            "",
            f"{self._verdict().capitalize()}.",
            "",
            *wrap(f"**Claim** ({self.source}). {self.claim}", LINE),
            "",
            *wrap(f"**Done.** {self.story}", LINE),
            "",
            "| what must be so | so? | seen |",
            "| --- | --- | --- |",
            *(
                f"| {check.name} | {'yes' if check.held else '**no**'} | {check.figure} |"
                for check in self.checks
            ),
        ]
        for each in self.tables:
            lines += ["", each.document()]
        lines += ["", f"`dray sim run {self.scenario} --seed {self.seed}`"]
        return "\n".join(lines)

    @property
    def failure(self) -> str:
        """The failed checks, for a message; empty when all held."""
        if self.invariants != HELD:
            return self.invariants
        failed = [f"{check.name}: no ({check.figure})" for check in self.checks if not check.held]
        return "; ".join(failed)

    def _verdict(self) -> str:
        return "held" if self.held else "did not hold"

    def _last_lines(self) -> dict[str, str]:
        told = {} if self.verdict is None else {"verdict": self.verdict.text}
        return {**self.measured, **told, "invariants": self.invariants, "trace": self.trace}


def _check_lines(check: Check) -> list[str]:
    return [f"  {'yes' if check.held else 'NO '}  {check.name}", f"       {check.figure}"]


def _columns(table: Table) -> list[str]:
    """The table in plain characters, numbers to the right."""
    rows = [table.head, *table.rows]
    widths = [max(len(row[column]) for row in rows) for column in range(len(table.head))]
    return ["    " + "  ".join(_cell(cell, i, widths[i]) for i, cell in enumerate(row)) for row in rows]


def _cell(cell: str, column: int, width: int) -> str:
    return cell.rjust(width) if column else cell.ljust(width)


def _row(cells: tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"
