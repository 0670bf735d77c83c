"""Run the campaigns that were not yet seen to hold on this code, and write what came of them into `docs/campaigns.md`.

Usage: python tools/run_campaign.py [options of pytest]

A campaign is a test module with tests that are marked `campaign`; the long runs of Hypothesis' tests are one more. Each
test that ends is kept in `artifacts/campaigns`, by the code that it ran on. So a campaign may be ended at any moment, by
Ctrl-C too, and the next call goes on with the tests that are missing. Whoever changes code, tests or locks begins anew.
A change of documents begins nothing anew.

The ledger has one row per code and campaign, the newest first. A test tells the seeds that it has played by pytest's
`record_property("seeds", ...)`.
"""

from __future__ import annotations

import datetime as dt
import json
import os
import signal
import sys
from collections import defaultdict
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TypedDict

import pytest

from dray_sim.explore.code_key import code_key

CODE = (
    "backend",
    "sim",
    "frontend",
    "migrations",
    "tests",
    "tools",
    "pyproject.toml",
    "requirements-dev.txt",
)
"""What a campaign's outcome depends on."""

KEPT = Path("artifacts/campaigns")

LEDGER = Path("docs/campaigns.md")

HEAD = """# Campaigns

Searches, mutants, losses, kills and fuzz at length. `make campaign` and `make search` write this file: one row per code and
campaign, the newest first, so the first row of a campaign says on which code its claim was last seen to hold. A commit with
`+` had changes that were not committed. Seeds are those that a run has played; whoever runs a row's campaign on its commit plays them again.

| day | commit | campaign | seen | seeds |
| --- | --- | --- | --- | --- |
"""

HELD = "DRAY_CAMPAIGNS_HELD"
"""Names the file of the tests that need not run again."""

AT_LENGTH = "tests that Hypothesis leads, at length"


class Outcome(TypedDict):
    """How a test of a campaign ended."""

    held: bool
    seeds: str
    why: str
    campaign: str


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave out what has held. This module is a plugin of each worker, too."""
    held = set(json.loads(Path(os.environ[HELD]).read_text(encoding="utf-8")))
    items[:] = [item for item in items if item.nodeid not in held]


class Ended:
    """A plugin of pytest that keeps how each test has ended, as soon as it has."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.outcomes: dict[str, Outcome] = (
            json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        )

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if not report.failed and report.when != "call":
            return
        properties = dict(report.user_properties)
        self.outcomes[report.nodeid] = Outcome(
            held=report.passed,
            seeds=str(properties.get("seeds", "")),
            why="" if report.passed else str(report.longrepr).strip().rpartition("\n")[2],
            campaign=report.nodeid.partition("::")[0] if "campaign" in report.keywords else AT_LENGTH,
        )
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(self.outcomes, indent=1), encoding="utf-8")


def main(options: list[str]) -> int:
    """Run what is missing; pytest's exit code, 1 as well when an earlier call has seen a test fail on this code."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    commit, digest = code_key(Path(), CODE)
    # What was not committed is run again once it is: rows are of a commit then.
    code = f"{digest}+" if commit.endswith("+") else digest
    ended = Ended(KEPT / f"{code}.json")
    held = [test for test, outcome in ended.outcomes.items() if outcome["held"]]
    if held:
        print(f"{len(held)} tests of campaigns have held on this code already", flush=True)
    left_out = KEPT / f"{code}.left-out"
    left_out.parent.mkdir(parents=True, exist_ok=True)
    left_out.write_text(json.dumps(held), encoding="utf-8")
    os.environ[HELD] = str(left_out.absolute())
    exit_code = int(pytest.main([*options, "-p", Path(__file__).stem], plugins=[ended]))
    if exit_code == pytest.ExitCode.NO_TESTS_COLLECTED and held:
        exit_code = 0
    _write_ledger(commit, ended.outcomes)
    return exit_code


def _write_ledger(commit: str, outcomes: dict[str, Outcome]) -> None:
    """Put this code's rows on top; its earlier ones go, since these count the same tests and more."""
    campaigns: dict[str, list[tuple[str, Outcome]]] = defaultdict(list)
    for test, outcome in outcomes.items():
        campaigns[outcome["campaign"]].append((test, outcome))
    day = dt.datetime.now(dt.UTC).date().isoformat()
    put_rows({(commit, name): _row(day, commit, name, tests) for name, tests in sorted(campaigns.items())})


def put_rows(rows: Mapping[tuple[str, str], str], gone: Collection[tuple[str, str]] = ()) -> None:
    """Put rows into the ledger, the newest day first.

    Args:
        rows: by commit and campaign; they replace those of the same.
        gone: commits and campaigns whose rows go, too.
    """
    before = LEDGER.read_text(encoding="utf-8").splitlines() if LEDGER.exists() else []
    kept = [line for line in before if line.startswith("| 2") and _key(line) not in {*rows, *gone}]
    lines = sorted((*rows.values(), *kept), key=_day, reverse=True)
    if lines:
        LEDGER.write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")


def _day(row: str) -> str:
    return row.split("|")[1].strip()


def _key(row: str) -> tuple[str, str]:
    cells = [cell.strip() for cell in row.split("|")]
    return cells[2], cells[3].strip("`")


def _row(day: str, commit: str, name: str, tests: list[tuple[str, Outcome]]) -> str:
    held = sum(outcome["held"] for _, outcome in tests)
    seen = f"{held} of {len(tests)} tests held"
    for test, outcome in tests:
        if not outcome["held"]:
            seen += f"; `{test.partition('::')[2]}` failed: {outcome['why']}".replace("|", "/")
    seeds = ", ".join(outcome["seeds"] for _, outcome in sorted(tests) if outcome["seeds"])
    shown = name if name == AT_LENGTH else f"`{name}`"
    return f"| {day} | {commit} | {shown} | {seen} | {seeds} |"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
