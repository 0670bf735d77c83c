"""What all tests share: a skipped test is never overlooked, a failed one is named at once.

On a developer's machine a test may be skipped, for want of a browser say; the run then ends with a loud
line that names it. Under CI (`CI=true`) nothing may be skipped: what would be, fails. What the machine itself
forbids (see `forbidden`) is named as loudly, and fails nowhere.
"""

from __future__ import annotations

import gc
import json
import os
import queue
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Generator, Iterator
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent / "kits"))

from databases import Files, Postgres
from examples import examples
from forbidden import Forbidden

from dray_sim.bench.postgres import MISSING, PostgresServer, installed

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
    call: pytest.CallInfo[None],
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
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

LONGEST = "test_fleet_update"
"""Begins first: one that takes minutes and begins last holds everybody up."""


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
    programs = installed()
    if programs is None:
        pytest.skip(MISSING)
    server = Postgres(programs)
    yield server
    server.close()


@pytest.fixture
def mortal_postgres() -> Iterator[PostgresServer]:
    """A PostgreSQL server for one test alone, which may kill it."""
    programs = installed()
    if programs is None:
        pytest.skip(MISSING)
    server = PostgresServer(programs)
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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items[:] = [item for item in items if not _is_needless(item)]
    for item in items:
        # What depends on the kind of database is the store's, whose own tests run on both in `make test`.
        if _is_on_postgresql(item) and _place(item).parts[0] != "store":
            item.add_marker(pytest.mark.slow)
    items.sort(key=lambda item: item.path.stem != LONGEST)


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

READY_S = 180.0
"""Longest wait for the line that names the panel: a cold start on a slow machine takes some 5 s."""

STOP_S = 60.0
"""Longest wait for a clean stop: connections get 3 s, the simulation one instant."""


ANSWER_S = 60.0
"""Longest wait for one answer."""

SESSION = "dray_session"
"""The cookie of a login."""


class _StayHere(urllib.request.HTTPRedirectHandler):
    """Asks for nothing more where an answer leads elsewhere."""

    def http_error_303(self, req: Any, fp: Any, code: int, msg: str, headers: Any) -> Any:
        return fp


class DrayProcess:
    """`dray up` in a process of its own.

    Attributes:
        url: where the panel is, without a slash at the end.
        token: the administrator's.
        links: per person without a secret, the address by which it logs in once.
        lines: what it has printed so far, stdout and stderr together.
    """

    def __init__(self, python: Path | str, *options: str, cwd: Path) -> None:
        command = [str(python), "-m", "dray", "up", *options]
        inherited = {name: value for name, value in os.environ.items() if name != "DRAY_ADMIN_TOKEN"}
        env = {**inherited, "PYTHONUNBUFFERED": "1", "COLUMNS": "200", "NO_COLOR": "1"}
        self.process = subprocess.Popen(
            command, cwd=cwd, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        self.lines: list[str] = []
        self._sessions: dict[str, str] = {}
        self._arrived: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        try:
            greeting = self._await_greeting()
        except BaseException:
            self.process.kill()
            self.process.wait()
            self._close()
            raise
        self.url = _found(r"Management panel\s+(\S+?)/?$", greeting)
        self.token = _found(r"Admin token\s+(\S+)$", greeting)
        self.links = dict(re.findall(r"^ +(\S+)\s+(http://\S+/login/\S+)$", greeting, re.MULTILINE))

    def ask(self, path: str, body: Any = None, **headers: str) -> Any:
        """Ask the API as the administrator: a GET, or a POST of a body."""
        data = None if body is None else json.dumps(body).encode()
        usual = {"Authorization": f"Bearer {self.token}", "Content-Type": "application/json"}
        request = urllib.request.Request(self.url + path, data, {**usual, **headers})
        with urllib.request.urlopen(request, timeout=ANSWER_S) as answer:
            return json.load(answer)

    def session(self, person: str = "manager") -> str:
        """The cookie of somebody who has logged in by the link that was printed, once for all who ask."""
        if person not in self._sessions:
            jar = CookieJar()
            opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar), _StayHere)
            opener.open(urllib.request.Request(self.links[person], b""), timeout=ANSWER_S).close()
            self._sessions[person] = next(cookie.value or "" for cookie in jar if cookie.name == SESSION)
        return self._sessions[person]

    def stop(self, by: signal.Signals = signal.SIGTERM) -> int:
        """Ask it to stop, as a terminal or a service manager does; its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(by)
        try:
            return self.process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            pytest.fail(f"dray up did not stop within {STOP_S} s:\n{self.output()}")
        finally:
            self._close()

    def kill(self) -> None:
        """End it as a power failure does."""
        self.process.kill()
        self.process.wait()
        self._close()

    def output(self) -> str:
        """Everything it has printed."""
        return "".join(self.lines)

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line)
            self._arrived.put(line)
        self._arrived.put(None)

    def _await_greeting(self) -> str:
        """All that it says until it answers."""
        ends_s = time.monotonic() + READY_S
        said = ""
        while "Ctrl-C" not in said:
            try:
                line = self._arrived.get(timeout=max(0.0, ends_s - time.monotonic()))
            except queue.Empty:
                pytest.fail(f"dray up was not ready within {READY_S} s:\n{self.output()}")
            if line is None:
                pytest.fail(f"dray up ended with {self.process.wait()}:\n{self.output()}")
            said += line
        return said

    def _close(self) -> None:
        self._reader.join(STOP_S)
        if self.process.stdout is not None:
            self.process.stdout.close()


def _found(pattern: str, text: str) -> str:
    found = re.search(pattern, text, re.MULTILINE)
    assert found is not None, text
    return found[1]


StartDray = Callable[..., DrayProcess]


@pytest.fixture(scope="session")
def running() -> dict[str, DrayProcess]:
    """Every `dray up` that was started so far, by its address."""
    return {}


@pytest.fixture(scope="session")
def start_dray(
    tmp_path_factory: pytest.TempPathFactory, running: dict[str, DrayProcess]
) -> Iterator[StartDray]:
    """Start `dray up` on a free port, by default with a database of its own; whatever still runs is stopped."""

    def start(*options: str, python: Path | str = sys.executable, url: str = "") -> DrayProcess:
        home = tmp_path_factory.mktemp("dray")
        url = url or f"sqlite:///{home / 'dray.db'}"
        dray = DrayProcess(python, "--port", "0", "--db", url, *options, cwd=home)
        running[dray.url] = dray
        return dray

    yield start
    for dray in running.values():
        dray.stop()
