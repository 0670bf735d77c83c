"""A scenario: a claim about the factory, the events that test it, and its judgement."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from dray.errors import SettingsError
from dray_sim.run.evidence import FIGURES, HELD, Check, Evidence, Table
from dray_sim.run.part import Part
from dray_sim.run.report import Report
from dray_sim.run.site import Site
from dray_sim.run.stage import Played, with_right_of_way, with_strategists

HERE = Site()
"""The scenario's own plant and load."""


class Outcome(Protocol):
    """The result of a run."""

    @property
    def failure(self) -> str:
        """The failed checks; empty when all held."""
        ...

    def describe(self) -> str:
        """A text for a reader; the same for the same seed."""
        ...

    def document(self) -> str:
        """A section of a Markdown document; the same for the same seed."""
        ...


class Playable(Protocol):
    """An entry of `dray sim list` and `dray sim run`."""

    @property
    def name(self) -> str: ...

    @property
    def shows(self) -> str:
        """One line of description."""
        ...

    @property
    def source(self) -> str:
        """Source of its claim; empty when there is none."""
        ...

    def run(self, seed: int, site: Site = HERE) -> Outcome:
        """Play it; everything that is left to chance follows from the seed.

        Raises:
            SettingsError: it can be played as it stands only, and `site` is another.
        """
        ...

    @property
    def moves(self) -> bool:
        """Whether it can be played in another plant."""
        ...


@dataclass(frozen=True, slots=True)
class Findings:
    """The findings of a scenario's runs.

    Attributes:
        runs: all of them; their invariants and traces go into the report.
        checks: the conditions of the claim.
        tables: figures beside it.
        measured: figures that depend on the computer.
    """

    runs: tuple[Played[Any], ...]
    checks: tuple[Check, ...]
    tables: tuple[Table, ...] = ()
    measured: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Scenario:
    """A claim and its proof.

    Attributes:
        name: as in `dray sim run NAME`.
        source: of the claim in the paper, or a note that it is ours.
        claim: in our words.
        story: the events.
        play: plays it, for a seed.
        elsewhere: plays it in another plant, under another load or for another time; None where the script names
            machines and vehicles of one plant.
        parts: those of its runs that can be followed live, step by step.
    """

    name: str
    shows: str
    source: str
    claim: str
    story: str
    play: Callable[[int], Findings]
    elsewhere: Callable[[int, Site], Findings] | None = None
    parts: tuple[Part[Any], ...] = ()

    @property
    def moves(self) -> bool:
        """Whether it can be played in another plant."""
        return self.elsewhere is not None

    def run(self, seed: int, site: Site = HERE) -> Evidence:
        """Play it, and compare the claim with the findings.

        Raises:
            SettingsError: it has only one plant and load, and `site` is another.
        """
        with with_right_of_way(site.traffic), with_strategists(site.strategists):
            found = self._play(seed, site)
        broken = [played.invariants for played in found.runs if played.invariants != HELD]
        runs = len(found.runs)
        unbroken = Check(
            "Every invariant held all the time",
            not broken,
            f"{runs - len(broken)} of {runs} run{'s' if runs > 1 else ''}",
        )
        checks = (*found.checks, unbroken)
        return Evidence(
            scenario=self.name,
            seed=seed,
            source=self.source,
            claim=self.claim,
            story=f"{self.story} Played here with {site}." if str(site) else self.story,
            held=all(check.held for check in checks),
            checks=checks,
            tables=found.tables,
            measured=found.measured,
            invariants=broken[0] if broken else HELD,
            trace=_fingerprint([played.report.trace for played in found.runs]),
            **_figures([played.report for played in found.runs]),
        )

    def _play(self, seed: int, site: Site) -> Findings:
        if not site.is_other:
            return self.play(seed)
        if self.elsewhere is not None:
            return self.elsewhere(seed, site)
        reason = (
            f"{self.name} is about certain machines and vehicles of one plant and is played as it stands only"
        )
        raise SettingsError("--plant, --load and --hours", reason)


def _figures(reports: list[Report]) -> dict[str, Any]:
    """Figures and verdict of the run in which the fewest orders were on time, the first of equal ones."""
    worst = min(reports, key=lambda report: report.on_time_frac if report.orders_due else 1.0)
    names = (*FIGURES, "verdict")
    return {name: getattr(worst, name) for name in names}


def _fingerprint(traces: list[str]) -> str:
    """One fingerprint for all runs: a single run keeps its own."""
    if len(traces) == 1:
        return traces[0]
    return hashlib.blake2b(" ".join(traces).encode(), digest_size=16).hexdigest()
