"""What all tests share: a skipped test is never overlooked, a failed one is named at once.

On a developer's machine a test may be skipped, for want of a browser say; the run then ends with a loud
line that names it. Under CI (`CI=true`) nothing may be skipped: what would be, fails. What the machine itself
forbids (see `forbidden`) is named as loudly, and fails nowhere. `tools/run_tests.py` runs a failed test again, alone.
"""

from __future__ import annotations

import faulthandler
import gc
import os
import signal
import sys
from collections import defaultdict
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import pytest
from _pytest.faulthandler import fault_handler_stderr_fd_key
from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent / "kits"))

from databases import Files
from dray_process import DrayProcess, SteppedServer
from examples import examples
from forbidden import Forbidden
from outcomes import HAS_FAILED

if TYPE_CHECKING:
    from postgres_databases import Postgres, PostgresServer

UNDER_CI = os.environ.get("CI", "").lower() in {"1", "true", "yes"}


Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)


def reason_of(report: pytest.TestReport | pytest.CollectReport) -> str:
    """Why a test was skipped or failed, in one line."""
    if isinstance(report.longrepr, tuple):
        return str(report.longrepr[2]).partition(": ")[2]
    crash = getattr(report.longrepr, "reprcrash", None)
    return str(report.longrepr if crash is None else crash.message).partition("\n")[0]


FORBIDDEN = "forbidden"
"""A test's outcome beside pytest's own: in a report's attribute, and in the summary."""


# No example fails for the time that it took: that says how busy the machine is. All else is Hypothesis' own choice.
settings.register_profile("without-deadline", settings(), deadline=None, max_examples=examples(100))
settings.load_profile("without-deadline")

# A shell lets a command that it starts in the background ignore Ctrl-C, and with it all that the tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
    call: pytest.CallInfo[None],
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    item.stash[HAS_FAILED] = item.stash.get(HAS_FAILED, False) or report.failed
    if call.excinfo is not None and call.excinfo.errisinstance(Forbidden):
        setattr(report, FORBIDDEN, True)
        return report
    return fail_when_skipped(report)


def pytest_report_teststatus(report: pytest.TestReport) -> tuple[str, str, str] | None:
    """A failure is named when it happens: who watches need not wait for the end, and a log cut short has it."""
    if hasattr(report, FORBIDDEN):
        return FORBIDDEN, "!", "FORBIDDEN"
    if report.failed:
        category = "failed" if report.when == "call" else "error"
        return category, f"\nFAILED {report.nodeid} ({report.when}): {reason_of(report)}\n", "FAILED"
    return None


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, None, None]:
    """Bound the teardown of a failed test: its timers are gone, since somebody might have debugged it."""
    timeout_s = float(item.config.getini("faulthandler_timeout") or 0)
    if timeout_s and item.stash.get(HAS_FAILED, False):
        # The end of pytest's own protocol takes this one back.
        faulthandler.dump_traceback_later(
            timeout_s, file=item.config.stash[fault_handler_stderr_fd_key], exit=True
        )
    yield


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    return fail_when_skipped(report)


def fail_when_skipped(report: Report) -> Report:
    """Under CI, turn a skip into a failure; an expected failure stays what it is."""
    if UNDER_CI and report.skipped and not hasattr(report, "wasxfail"):
        report.longrepr = f"skipped, which CI does not allow: {reason_of(report)}"
        report.outcome = "failed"
    return report


LOUD = (
    ("skipped", "WERE SKIPPED"),
    (FORBIDDEN, "ARE FORBIDDEN BY THIS MACHINE"),
)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    for outcome, words in LOUD:
        reports = terminalreporter.stats.get(outcome, [])
        if reports:
            terminalreporter.write_sep("!", f"{len(reports)} TESTS {words}", red=True, bold=True)
        for report in reports:
            terminalreporter.write_line(f"!!! {report.nodeid}: {reason_of(report)}", red=True, bold=True)


# --- what runs when -----------------------------------------------------------------------------------

LONGEST = (
    "browser/manager/test_order_page",
    "gateway/routes/test_loop_steps",
    "browser/test_every_page",
    "browser/operator/test_duty",
    "simulation/factory/test_charging",
    "simulation/scenarios/test_scenarios",
    "gateway/routes/test_openapi",
    "simulation/explore/test_mutants",
    "delivery/test_packaging",
    "browser/manager/test_morning",
    "simulation/explore/test_explore",
    "browser/manager/test_cards_in_sight",
    "store/test_migrate",
    "gateway/live/test_areas_rest",
)
"""Modules of `make test` and `make test-long` that take more than 70 s on one worker (`artifacts/durations.json`), the longest first."""

BROWSER = "browser/"
"""The folder of tests of which each takes seconds, where others take some hundredths of one."""

WAITING = (
    "adapters/vda5050/test_vda5050_independent",
    "adapters/zenoh",
    "cli/fleet",
    "cli/simulation",
    "cli/test_service_without_simulator",
    "delivery/test_service",
    "delivery/test_vehicle_ts",
    "simulation/controllers",
    "traffic/test_slow_links",
)
"""Modules and folders whose tests wait for other processes in real time, and hardly compute."""


def _place(item: pytest.Item) -> Path:
    """Its module, from here."""
    return Path(os.path.relpath(item.path.with_suffix(""), Path(__file__).parent))


# --- databases ---------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """SQLite databases."""
    return Files(tmp_path_factory.mktemp("empty"))


@pytest.fixture(scope="session")
def postgres() -> Iterator[Postgres]:
    """A PostgreSQL server, one for all tests."""
    # All benchmarks come with it: two seconds of a processor, also for a process that only reads this file.
    from postgres_databases import Postgres, programs  # noqa: PLC0415

    server = Postgres(programs())
    yield server
    server.close()


@pytest.fixture
def mortal_postgres() -> Iterator[PostgresServer]:
    """A PostgreSQL server for one test alone, which may kill it."""
    from postgres_databases import PostgresServer, programs  # noqa: PLC0415

    server = PostgresServer(programs())
    yield server
    server.close()


@pytest.fixture
def sqlite_url(files: Files, tmp_path: Path) -> str:
    """An empty database on SQLite."""
    return files.new(tmp_path)


@pytest.fixture
def postgresql_url(postgres: Postgres) -> Iterator[str]:
    """An empty database on PostgreSQL."""
    url = postgres.new()
    yield url
    postgres.take_back(url)


SQLITE_ONLY = frozenset(
    f"test_{noun}"
    for noun in (
        "access",
        "areas",
        "areas_rest",
        "audit_log",
        # Refused before any database is asked; test_openapi tries on both what neither may hold.
        "bad_addresses",
        "bad_input",
        "commands",
        "fault_injection",
        "keys",
        "live",
        "login_pages",
        "metrics",
        "middleware",
        "pages",
        "revocations",
        "sessions",
        "stream",
        "stream_access",
        "stream_socket",
        "track",
        "track_links",
        "why",
    )
)
"""Modules of the gateway in which the kind of database has no part, or none that the store's own tests do not have:
on both, they would take two minutes for nothing."""


SEVERAL_AT_ONCE = frozenset(
    f"test_{noun}"
    for noun in (
        "alert_history_several",
        "alerts_taken",
        "call_limits",
        "database_sync",
        "exclusions",
        "idempotency",
        "order_changes",
        "orders",
        "outbox",
        "people",
        "queries",
        "reconciliation",
        "recurring_orders",
        "shared_orders",
    )
)
"""Modules of the gateway that are about several who write at once, or about how rows are found: there the databases differ."""

ONE_OF = 3
"""Of the tests of each other module so many have one on PostgreSQL in `make test-long`, the first among them; the others are left to
`make campaign`. All are in `make test` on SQLite, and those of the store on both."""


def choose(items: list[pytest.Item]) -> None:
    """Leave out what is needless, and mark what waits for `make test-long` or a campaign."""
    items[:] = [item for item in items if not _is_needless(item)]
    numbers: defaultdict[Path, Iterator[int]] = defaultdict(count)
    for item in items:
        # What depends on the kind of database is the store's, whose own tests run on both in `make test`.
        if _is_on_postgresql(item) and _place(item).parts[0] != "store":
            soon = next(numbers[item.path]) % ONE_OF == 0 or item.path.stem in SEVERAL_AT_ONCE
            item.add_marker(pytest.mark.slow if soon else pytest.mark.campaign)


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> Generator[None, None, None]:
    choose(items)
    # After what else chooses, by marks and by what failed last.
    yield
    items[:] = mixed(items, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))


def mixed(items: list[pytest.Item], workers: int) -> list[pytest.Item]:
    """Tests in the order in which they use all processors to the end.

    Each worker begins with its own share of the list, and all shares have as many tests. A worker that has done its share takes half of
    the longest list, from that list's end. So the long modules are dealt out to the shares, those of `LONGEST` first, then all with a
    browser, and each share ends with short tests. The long modules of each share begin a part of it later than those of the share before:
    browsers compute much, and are not all open at the same time. The tests that wait for processes begin at the begin of two shares.
    """
    own: defaultdict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        own[str(_place(item))].append(item)
    long = [module for module in LONGEST if module in own]
    long += [module for module in own if module.startswith(BROWSER) and module not in LONGEST]
    waiting = [item for module, each in own.items() if module.startswith(WAITING) for item in each]
    dealt = {item for module in long for item in own[module]} | set(waiting)
    short = [item for item in items if item not in dealt]

    shares: list[list[pytest.Item]] = [[] for _ in range(workers)]
    for number, module in enumerate(long):
        lap, place = divmod(number, workers)
        shares[place if lap % 2 == 0 else workers - 1 - place] += own[module]
    waits: list[list[pytest.Item]] = [[] for _ in range(workers)]
    half = len(waiting) // 2
    waits[0] += waiting[:half]
    waits[workers // 2] += waiting[half:]

    order: list[pytest.Item] = []
    for number, (longs, waits_first) in enumerate(zip(shares, waits, strict=True), 1):
        room = len(items) * number // workers - len(order) - len(longs) - len(waits_first)
        fill, short = short[: max(0, room)], short[max(0, room) :]
        before = len(fill) * (number - 1) // workers
        order += [*waits_first, *fill[:before], *longs, *fill[before:]]
    return [*order, *short]


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    # What was imported and collected stays to the end: the collector of garbage need not look through it again and again.
    gc.collect()
    gc.freeze()


def _is_needless(item: pytest.Item) -> bool:
    return _is_on_postgresql(item) and _place(item).parts[0] == "gateway" and item.path.stem in SQLITE_ONLY


def _is_on_postgresql(item: pytest.Item) -> bool:
    callspec = getattr(item, "callspec", None)
    return callspec is not None and callspec.params.get("url") == "postgresql"


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request: pytest.FixtureRequest) -> str:
    """An empty database; a test that asks for one runs on each kind."""
    url: str = request.getfixturevalue(f"{request.param}_url")
    return url


# --- `dray up` as a process --------------------------------------------------------------------------

StartDray = Callable[..., DrayProcess]


@pytest.fixture(scope="session")
def running() -> dict[str, DrayProcess]:
    """Every `dray up` that was started so far, by its address."""
    return {}


@pytest.fixture(scope="session")
def start_dray(
    tmp_path_factory: pytest.TempPathFactory, files: Files, running: dict[str, DrayProcess]
) -> Iterator[StartDray]:
    """Start `dray up` on a free port, by default with a database of its own; whatever still runs is stopped.

    Those that are `stepped` are forked, where the system allows it, and find their tables made: importing all of it takes two
    seconds of a processor. All others are the command itself, on a database that is not there yet.
    """
    server: list[SteppedServer] = []

    def start(
        *options: str, python: Path | str = sys.executable, url: str = "", stepped: bool = False
    ) -> DrayProcess:
        home = tmp_path_factory.mktemp("dray")
        url = url or (files.new(home) if stepped else f"sqlite:///{home / 'dray.db'}")
        if stepped and (not server or server[-1].ended) and hasattr(os, "pidfd_open"):
            server.append(SteppedServer())
        forks = server[-1] if server else None
        dray = DrayProcess(
            python, "--port", "0", "--db", url, *options, cwd=home, stepped=stepped, server=forks
        )
        running[dray.url] = dray
        return dray

    with ExitStack() as stack:
        yield start
        for each in server:
            stack.callback(each.close)
        for dray in running.values():
            stack.callback(dray.stop)
