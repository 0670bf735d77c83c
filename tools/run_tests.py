"""Run pytest on all workers, then run each failed test again alone.

Usage: python tools/run_tests.py NAME [options of pytest]

A failure beside other tests may say that the machine was busy. A failure alone, twice in a row, is one of the
test or of what it tests. So the tests that fail in the parallel run are run again after it, on one worker,
at most `TRIES_ALONE` times. Tests that pass then are `unsteady`: they are named loudly at the end and kept in
`artifacts/unsteady.json`, by the run's NAME, and the run is green. How long each module took in the parallel run stands in
`artifacts/durations.json`, by the run's NAME, the longest first.

A test that runs for minutes is named meanwhile, and one that hangs is a failure once pytest's `timeout` ends it. A test whose process dies is a failure of that test;
pytest-xdist starts another worker.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Iterable
from pathlib import Path

import pytest

TRIES_ALONE = 2

AGAIN = ("--last-failed", "--last-failed-no-failures", "none")

FAILED_MAX = 40
"""Most failed tests that are run again. More of them have one cause, and are too many for the time of a check."""

UNSTEADY = Path("artifacts/unsteady.json")
"""Per name of a run its unsteady tests, each with the first line of its first failure."""

DURATIONS = Path("artifacts/durations.json")
"""Per name of a run its modules, with the seconds that their tests took and waited in all."""


LONG_S = 300.0
"""A test that takes longer is named while it runs: it hangs, or the computer is very busy."""

LOOK_S = 30.0


class Failures:
    """A plugin of pytest that keeps what failed.

    Attributes:
        tests: per failed test the first line of its first failure.
        is_collected: whether every module was read.
        took_s: per module how long its tests took, with what they set up.
    """

    def __init__(self, again: Iterable[str] = ()) -> None:
        """Start with the tests that are run again: each has failed until it passes."""
        self.tests = dict.fromkeys(again, "did not run again")
        self.is_collected = True
        self.took_s: dict[str, float] = {}
        self._failed: set[str] = set()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        module = report.nodeid.partition("::")[0]
        self.took_s[module] = self.took_s.get(module, 0.0) + report.duration
        if report.failed and report.nodeid not in self._failed:
            self._failed.add(report.nodeid)
            self.tests[report.nodeid] = first_line(report)
        elif report.passed and report.when == "call" and report.nodeid not in self._failed:
            self.tests.pop(report.nodeid, None)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        self.is_collected &= not report.failed


class Watch:
    """A plugin of pytest that names a test that does not end, for whoever reads a run that was cut off."""

    def __init__(self) -> None:
        self._begun_s: dict[str, float] = {}
        self._ended = threading.Event()

    def pytest_sessionstart(self) -> None:
        threading.Thread(target=self._look, daemon=True).start()

    def pytest_sessionfinish(self) -> None:
        self._ended.set()

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.began(nodeid, time.monotonic())

    def began(self, test: str, now_s: float) -> None:
        self._begun_s[test] = now_s

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self._begun_s.pop(nodeid, None)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        # A test whose process has died has no other end: pytest-xdist reports it as of no phase.
        if report.when not in ("setup", "call", "teardown"):
            self._begun_s.pop(report.nodeid, None)

    def overdue(self, now_s: float) -> dict[str, float]:
        """Tests that run for long, with their seconds so far; each is named once."""
        overdue = {
            test: now_s - begun_s
            for test, begun_s in list(self._begun_s.items())
            if now_s - begun_s >= LONG_S
        }
        for test in overdue:
            self._begun_s.pop(test, None)
        return overdue

    def _look(self) -> None:
        while not self._ended.wait(LOOK_S):
            for test, took_s in self.overdue(time.monotonic()).items():
                print(f"\nhas run for {took_s:.0f} s: {test}", flush=True)


def first_line(report: pytest.TestReport) -> str:
    """Why the test failed. The report of a worker that died has no crash, and its text is the reason."""
    crash = getattr(report.longrepr, "reprcrash", None)
    return str(report.longrepr if crash is None else crash.message).strip().partition("\n")[0]


def main(name: str, options: list[str]) -> int:
    """Run the tests, and again alone what failed; the exit code of pytest that the whole amounts to."""
    # The cache tells the later runs which tests had failed; a cache per name, since two runs may go on at once.
    options = [*options, "-o", f"cache_dir=.pytest_cache/{name}"]
    first = Failures()
    code = int(pytest.main([*options, "--cache-clear"], plugins=[first, Watch()]))
    failed = first
    for attempt in range(1, TRIES_ALONE + 1):
        if not may_be_chance(code, failed):
            break
        _say(f"{len(failed.tests)} failed: again alone, {attempt} of {TRIES_ALONE}")
        failed = Failures(failed.tests)
        code = int(pytest.main([*options, *AGAIN, "-n", "1"], plugins=[failed, Watch()])) or int(
            bool(failed.tests)
        )
    longest = sorted(first.took_s.items(), key=lambda each: -each[1])
    _note(DURATIONS, name, {module: round(took_s, 1) for module, took_s in longest})
    unsteady = {test: reason for test, reason in first.tests.items() if test not in failed.tests}
    keep(name, unsteady)
    _say(f"unsteady: {len(unsteady)}", unsteady)
    if code:
        _say(f"failed: {len(failed.tests)}", failed.tests)
    return code


def may_be_chance(code: int, failures: Failures) -> bool:
    """Whether tests failed, so few that each may have failed by chance, and nothing else went wrong."""
    return (
        code == pytest.ExitCode.TESTS_FAILED
        and failures.is_collected
        and 0 < len(failures.tests) <= FAILED_MAX
    )


def keep(name: str, unsteady: dict[str, str]) -> None:
    """Write the unsteady tests of this run beside those of runs of other names."""
    _note(UNSTEADY, name, [{"test": test, "first_failure": reason} for test, reason in unsteady.items()])


def _note(file: Path, name: str, told: object) -> None:
    file.parent.mkdir(exist_ok=True)
    runs = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    file.write_text(json.dumps(runs | {name: told}, indent=2) + "\n", encoding="utf-8")


def _say(title: str, tests: dict[str, str] | None = None) -> None:
    print(f"\n!!!!!! {title} !!!!!!", flush=True)
    for test, reason in (tests or {}).items():
        print(f"!!! {test}: {reason}", flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
