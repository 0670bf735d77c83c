"""A real Chromium before a real `dray up`, whose time passes where a test lets it.

The browser is an installed one; the pages are those of the built panels. Whatever the page complains of
(a console error, an exception, a request that failed) fails the test that opened it; so does a request
to another host, and what breaks WCAG 2.2 AA in a state that is kept as a picture, or at the end where there is none.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright
from playwright.sync_api import Error as PlaywrightError

sys.path.insert(0, str(Path(__file__).parent))

from complaints import Complaints
from databases import Files
from outcomes import HAS_FAILED
from tablet_kit import enter, house, vehicles  # noqa: F401 - fixtures

ROOT = Path(__file__).resolve().parents[2]
ARTIFACTS = ROOT / "artifacts/screenshots"

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
"""The shell is the same engine without what stands around a page in a window: each fresh page costs a third."""

QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
"""Works as root and in a container, and speaks to nobody but the page's server."""


def where_it_is_ten() -> str:
    """The time zone in which it is between ten and eleven now: an hour more or less is never another day."""
    ahead_h = (22 - datetime.now(UTC).hour) % 24 - 12
    return f"Etc/GMT{-ahead_h:+d}"


USUAL = {
    "viewport": {"width": 1280, "height": 800},
    "locale": "en-GB",
    "reduced_motion": "reduce",
    "timezone_id": where_it_is_ten(),
}
"""The smallest screen that the management panel is made for; vehicles are drawn where they are, sixty pictures a second
less. What is due in an hour is due today, whenever the tests run."""

TIMEOUT_MS = 45_000
"""Longest wait for something on the page: some fifty times what it takes, so that a busy computer is no fault of it."""

CAPTURES = 3
"""Tries at a picture."""

BEEN_HERE = "try { localStorage.setItem('dray.tour.1', 'seen') } catch { /* a page without an address */ }"
"""The tour of the management panel is for who comes for the first time."""

expect.set_options(timeout=TIMEOUT_MS)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    here = f"{Path(__file__).parent}{os.sep}"
    for item in items:
        # Ten thousand of them: a path's parents would take a second of each of pytest's processes.
        if str(item.path).startswith(here):
            item.add_marker(pytest.mark.browser)


class Chromium:
    """The browser of all tests in a row that ask for one. Starting it takes half a second of a processor."""

    def __init__(self) -> None:
        self._stack = ExitStack()
        self._browser: Browser | None = None

    def get(self) -> Browser:
        """It is started, if it is not there."""
        if self._browser is not None and self._browser.is_connected():
            return self._browser
        self.close()
        path = next(filter(None, map(shutil.which, NAMES)), None)
        if path is None:
            pytest.skip("no Chromium is installed; on Debian: apt-get install chromium-headless-shell")
        playwright = self._stack.enter_context(sync_playwright())
        self._browser = playwright.chromium.launch(executable_path=path, args=list(QUIET))
        self._stack.callback(self._browser.close)
        return self._browser

    def close(self) -> None:
        """It ends, and Playwright with it."""
        self._browser = None
        self._stack.close()


CHROMIUM = Chromium()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(nextitem: pytest.Item | None) -> Iterator[None]:
    try:
        return (yield)
    finally:
        # Not for the whole session: while Playwright is there, no test may start an event loop of its own.
        if "browser" not in getattr(nextitem, "fixturenames", ()):
            CHROMIUM.close()


@pytest.fixture(scope="module")
def browser(files: Files) -> Browser:
    """A Chromium. The empty database, which takes an event loop to make, is made before it starts."""
    return CHROMIUM.get()


@pytest.fixture(scope="module")
def quiet(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """A factory in which nobody orders but the tests of a module. Its time stands; a test lets it pass."""
    dray = start_dray("--speed", "20", "--no-demand", stepped=True)
    # Everybody has been heard.
    dray.advance(5.0)
    yield dray
    assert dray.stop() == 0, dray.output()


@pytest.fixture(scope="session")
def busy(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """A factory with customers, which has worked for a while. Its time stands; a test lets it pass.

    It is for all tests, and none orders anything there.
    """
    dray = start_dray("--speed", "10", "--seed", "3", stepped=True)
    dray.advance_until(lambda: is_busy(dray.ask("/api/kpis")), step_s=10.0)
    yield dray
    assert dray.stop() == 0, dray.output()


def is_busy(figures: dict[str, Any]) -> bool:
    """Whether a plant is at work: transports were finished, and several vehicles drive."""
    return bool(figures["transport_p50_s"]) and figures["atvs_by_status"].get("working", 0) >= 3


@pytest.fixture
def complaints() -> Complaints:
    """What this test's pages have complained of so far."""
    return Complaints()


@pytest.fixture
def open_page(
    browser: Browser, complaints: Complaints, running: Mapping[str, Any], request: pytest.FixtureRequest
) -> Iterator[Callable[..., Page]]:
    """Open an address in a fresh profile; complaints are looked at when the test is over.

    `who` is logged in at the `dray up` of that address, or at the one that is visited later. A `first_time` is that
    of a browser that has seen no panel yet.
    """
    pages: list[Page] = []
    contexts: list[BrowserContext] = []

    def open_at(
        url: str,
        *,
        who: str | None = "manager",
        visits: str = "",
        first_time: bool = False,
        **options: object,
    ) -> Page:
        context = browser.new_context(**USUAL | options)
        contexts.append(context)
        if not first_time and options.get("java_script_enabled") is not False:
            context.add_init_script(BEEN_HERE)
        dray = next((each for home, each in running.items() if (visits or url).startswith(home)), None)
        if dray is not None and who is not None:
            cookie = {"name": "dray_session", "value": dray.session(who), "url": dray.url}
            context.add_cookies([cookie | {"httpOnly": True, "sameSite": "Strict"}])
        page = context.new_page()
        pages.append(page)
        page.set_default_timeout(TIMEOUT_MS)
        complaints.watch(page)
        if options.get("java_script_enabled") is False:
            complaints.without_script.append(page)
        page.goto(url)
        return page

    yield open_at
    try:
        # In the page of a failed test the clock may stand still, and axe would wait for it without end.
        for page in pages if not request.node.stash.get(HAS_FAILED, False) else ():
            complaints.audit_once(page)
        found = list(complaints)  # closing ends requests on their way, which is no complaint
    finally:
        for context in contexts:
            # A request that a test answers by itself ends with its page, and is no fault of the next test.
            for page in context.pages:
                page.unroute_all(behavior="ignoreErrors")
            context.close()
    assert not found, "\n".join(found)


@pytest.fixture
def screenshot(complaints: Complaints) -> Callable[..., Path]:
    """Keep a picture in artifacts/screenshots, and complain of what is not accessible in it where it is `audited`."""

    def keep(page: Page, name: str, *, whole: bool = False, of: str = "", audited: bool = True) -> Path:
        ARTIFACTS.mkdir(parents=True, exist_ok=True)
        path = ARTIFACTS / f"{name}.png"
        _capture(
            lambda: (
                page.locator(of).screenshot(path=path) if of else page.screenshot(path=path, full_page=whole)
            )
        )
        if audited:
            complaints.audit(page)
        return path

    return keep


def _capture(take: Callable[[], bytes]) -> None:
    """Take a picture. Chromium has none to give at some moments, which says nothing about the page."""
    for _ in range(CAPTURES - 1):
        try:
            take()
        except PlaywrightError as error:
            if "Unable to capture screenshot" not in error.message:
                raise
        else:
            return
    take()
