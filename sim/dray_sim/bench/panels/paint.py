"""Benchmark `paint`: how long a page stays blank at its first visit.

The time runs from the request to the first text or picture (First Contentful Paint), with an empty cache, from a
server on the same machine, in a headless Chromium. The baseline is the plainest page there is: one line of text.

Then the management panel over slow links, which the browser simulates: how long it takes until moving vehicles are
shown. The baseline is the same page at once.
"""

from __future__ import annotations

import json
import time
import urllib.request
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

from dray_sim.bench.panels.browser import chromium, profile
from dray_sim.bench.panels.crowd import Crowd
from dray_sim.bench.panels.panel import House, serving
from dray_sim.bench.row import Row

if TYPE_CHECKING:
    from playwright.sync_api import Browser

VEHICLES = 8
"""The default plant's."""

TIMES, QUICK_TIMES = 9, 3
"""A page is opened so often; the middle one counts."""

TARGET_MS = 1_000.0
"""Longest wait in which people keep their train of thought."""


@dataclass(frozen=True, slots=True)
class Page:
    """A page to open.

    Attributes:
        path: its address in the house.
        session: of the visitor; empty for a page without a login.
    """

    path: str
    session: str = ""


PLAINEST = Page("/healthz")


@dataclass(frozen=True, slots=True)
class Line:
    """The link of a browser's computer.

    Attributes:
        name: in words.
        bit_per_s: in either direction.
        latency_ms: before each answer begins.
        target_ms: longest time until the vehicles are shown.
    """

    name: str
    bit_per_s: float
    latency_ms: float
    target_ms: float


LIVE = ".swatch.share-working"
"""Selector of the card that counts what vehicles do: it appears with the first picture of the stream."""

LIVE_MOST_S = 120.0
"""Longest wait."""

LINES = (
    Line("1.6 Mbit/s", 1.6e6, 150.0, 3_000.0),
    Line("400 kbit/s", 400e3, 400.0, 8_000.0),
)
"""Lines of a phone in a hall, with latencies as Lighthouse has them."""

PAINTED = """() => new Promise((painted) => {
    const told = (entries) => {
        const first = entries.find(({ name }) => name === "first-contentful-paint");
        if (first) painted(first.startTime);
    };
    new PerformanceObserver((list) => told(list.getEntries())).observe({ type: "paint", buffered: true });
})"""


def measure(quick: bool) -> list[Row]:
    """Measure the pages.

    Args:
        quick: a third of the work.
    """
    times = QUICK_TIMES if quick else TIMES
    with chromium() as browser, serving(Crowd(VEHICLES)) as house:
        pages = {
            "management panel": Page("/", house.session),
            "operator panel": Page("/operator", house.operators),
            "login page": Page("/login"),
            "customer page": Page(_order(house)),
        }
        plainest_ms = _painted_ms(browser, house, PLAINEST, times)
        at_once_ms = _live_ms(browser, house, None, times)
        return [
            Row(
                f"paint: {name}",
                _painted_ms(browser, house, page, times),
                "ms",
                plainest_ms,
                "a page of one line",
                TARGET_MS,
                "first contentful paint, empty cache",
                less=True,
            )
            for name, page in pages.items()
        ] + [
            Row(
                f"paint: first live picture at {line.name}",
                _live_ms(browser, house, line, times),
                "ms",
                at_once_ms,
                "without such a line",
                line.target_ms,
                f"{VEHICLES} vehicles in the management panel, empty cache, {line.latency_ms:.0f} ms of latency",
                less=True,
            )
            for line in LINES
        ]


def _live_ms(browser: Browser, house: House, line: Line | None, times: int) -> float:
    """How long it takes until a vehicle of the stream is in the panel."""
    return median(_live_once_ms(browser, house, line) for _ in range(times))


def _live_once_ms(browser: Browser, house: House, line: Line | None) -> float:
    with profile(browser, house, house.session) as context:
        tab = context.new_page()
        if line is not None:
            network = context.new_cdp_session(tab)
            network.send("Network.enable")
            thin = {
                "offline": False,
                "latency": line.latency_ms,
                "downloadThroughput": line.bit_per_s / 8,
                "uploadThroughput": line.bit_per_s / 8,
            }
            network.send("Network.emulateNetworkConditions", thin)
        begun_s = time.perf_counter()
        tab.goto(house.url, wait_until="commit")
        tab.locator(LIVE).first.wait_for(timeout=LIVE_MOST_S * 1000)
        return 1000 * (time.perf_counter() - begun_s)


def _painted_ms(browser: Browser, house: House, page: Page, times: int) -> float:
    return median(_once_ms(browser, house, page) for _ in range(times))


def _once_ms(browser: Browser, house: House, page: Page) -> float:
    with profile(browser, house, page.session) as context:
        tab = context.new_page()
        tab.goto(house.url + page.path)
        return float(tab.evaluate(PAINTED))


def _order(house: House) -> str:
    """Place an order; the path of its customer's page."""
    body = {"customer": "Bench", "items": [{"product": "gear-unit-g1", "quantity": 40}]}
    request = urllib.request.Request(  # noqa: S310 (our own server)
        f"{house.url}/api/orders",
        json.dumps(body).encode(),
        {"Authorization": f"Bearer {house.admin_token}", "Content-Type": "application/json"},
    )
    with urllib.request.urlopen(request) as answer:  # noqa: S310
        tracking: str = json.load(answer)["tracking_url"]
    return tracking.removeprefix(house.url)
