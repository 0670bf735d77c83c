"""A real Chromium before a real `dray up`.

The browser is an installed one; the pages are those of the built panels. Whatever the page complains of
(a console error, an exception, a request that failed) fails the test that opened it.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, Request, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
ARTIFACTS = ROOT / "artifacts/screenshots"

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

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

VIEWPORT = {"width": 1280, "height": 800}
"""The smallest screen that the management panel is made for."""

TIMEOUT_MS = 15_000
"""Longest wait for something on the page: ten times what it takes on a slow machine."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.browser)


# Not for the whole session: while Playwright is there, no test may start an event loop of its own.
@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip("no Chromium is installed; on Debian: apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(QUIET))
        yield browser
        browser.close()


class Complaints(list[str]):
    """What a page has complained of."""

    def watch(self, page: Page) -> None:
        page.on("console", self._console)
        page.on("pageerror", lambda error: self.append(f"exception: {error}"))
        page.on("requestfailed", self._failed)

    def _console(self, message: ConsoleMessage) -> None:
        if message.type in {"error", "warning"}:
            self.append(f"console {message.type}: {message.text}")

    def _failed(self, request: Request) -> None:
        self.append(f"request failed: {request.method} {request.url}: {request.failure}")


@pytest.fixture
def open_page(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Open an address in a fresh profile; complaints are looked at when the test is over."""
    complaints, contexts = Complaints(), []

    def open_at(url: str, **options: object) -> Page:
        context = browser.new_context(**{"viewport": VIEWPORT, "locale": "en-GB", **options})
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(TIMEOUT_MS)
        complaints.watch(page)
        page.goto(url)
        return page

    yield open_at
    found = list(complaints)  # closing ends requests on their way, which is no complaint
    for context in contexts:
        context.close()
    assert not found


@pytest.fixture
def screenshot() -> Callable[[Page, str], Path]:
    """Keep a picture in artifacts/screenshots."""

    def keep(page: Page, name: str) -> Path:
        ARTIFACTS.mkdir(parents=True, exist_ok=True)
        path = ARTIFACTS / f"{name}.png"
        page.screenshot(path=path)
        return path

    return keep
