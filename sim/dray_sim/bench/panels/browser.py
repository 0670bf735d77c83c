"""A real Chromium for the benchmarks of the panels, headless and without a graphics card.

The processor that runs the script also paints every picture, so a desk's computer is quicker.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from dray.errors import UnavailableError
from dray.gateway.access.gate import COOKIE
from dray_sim.bench.panels.panel import House

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, ViewportSize

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chromium-headless-shell")

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
"""Flags that work as root and in a container; the browser connects to the panel's server only."""

SCREEN: ViewportSize = {"width": 1920, "height": 1080}
"""A control room's; the management panel is made for 1,280 x 800 and more."""


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser that is closed in the end.

    Raises:
        UnavailableError: there is no Chromium, or nothing to steer it with.
    """
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        raise UnavailableError(
            "Chromium", "is not installed", "install it; on Debian: apt-get install chromium"
        )
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415 (only development has it)
    except ImportError:
        raise UnavailableError("playwright", "is not installed", "run `make setup`") from None
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        try:
            yield browser
        finally:
            browser.close()


def profile(browser: Browser, house: House, session: str) -> BrowserContext:
    """A fresh profile with an empty cache.

    Args:
        browser: whose.
        house: which is to be looked at.
        session: of the person who is logged in; empty for nobody.
    """
    context = browser.new_context(viewport=SCREEN)
    if session:
        context.add_cookies([{"name": COOKIE, "value": session, "url": house.url}])
    return context
