"""Benchmark `map`: the cost of one picture of the management panel's map with 50, 200 and 1,000 moving vehicles.

The panel is the built one, in a headless Chromium; its stream is a real websocket of a whole gateway. Two baselines
run in the same browser: the same panel with 8 vehicles, and an empty canvas that only parses the same stream.

Script is all JavaScript between two pictures, counted by the browser: the picture itself, the frames of the stream,
and the cards around the map. Painting does not count as script. Without a graphics card the processor paints as well,
so the time between pictures includes that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from dray_sim.bench.panels.browser import chromium, profile
from dray_sim.bench.panels.crowd import Crowd
from dray_sim.bench.panels.panel import House, serving
from dray_sim.bench.row import Row

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

VEHICLES, FEW = (50, 200, 1_000), 8
"""Plants of all sizes, and the default one."""

SPAN_S, QUICK_SPAN_S = 15.0, 4.0
"""Duration of one measurement: some hundreds of pictures."""

SETTLED_S = 3.0
"""Warm-up: every vehicle has been heard twice, and the compiler has optimised the hot code."""

NEAR_STEPS = 5
"""Presses of +, from the whole plant to some fifty vehicles with noses, names, ways and links."""

TARGET_MS = {200: 4.0, 1_000: 8.0}
"""Aims by vehicles, for script per picture: a quarter and half of the time between pictures at 60 Hz."""

WATCH = """() => {
    const real = window.requestAnimationFrame.bind(window);
    window.pictures = [];
    window.requestAnimationFrame = (draw) => real((ms) => {
        const begun = performance.now();
        draw(ms);
        const took = performance.now() - begun;
        const last = window.pictures.at(-1);
        if (last && last[0] === ms) last[1] += took;
        else window.pictures.push([ms, took]);
    });
}"""
"""Notes when each picture was drawn, and how long the script for it took."""

EMPTY = """() => {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width: innerWidth, height: innerHeight });
    document.body.replaceChildren(canvas);
    const context = canvas.getContext("2d");
    const url = new URL("/api/stream", location.href);
    url.protocol = "ws:";
    new WebSocket(url).onmessage = ({ data }) => JSON.parse(data);
    const draw = () => { context.clearRect(0, 0, canvas.width, canvas.height); requestAnimationFrame(draw); };
    requestAnimationFrame(draw);
}"""


@dataclass(frozen=True, slots=True)
class Pictures:
    """Measurements of the pictures of some seconds, in milliseconds."""

    drawn_ms: tuple[float, ...]
    """Script of each picture alone, ascending."""
    apart_ms: tuple[float, ...]
    """Time between successive pictures, ascending."""
    script_ms: float
    """All script, per picture."""


def measure(quick: bool) -> list[Row]:
    """Measure the map.

    Args:
        quick: a quarter of the time.
    """
    span_s = QUICK_SPAN_S if quick else SPAN_S
    with chromium() as browser:
        with serving(Crowd(FEW)) as house:
            few = {near: _panel(browser, house, span_s, near) for near in (False, True)}
        rows: list[Row] = []
        for vehicles in VEHICLES:
            with serving(Crowd(vehicles)) as house:
                empty = _empty(browser, house, span_s)
                for near, view in ((False, "whole plant"), (True, "near")):
                    many = _panel(browser, house, span_s, near)
                    rows += _rows(vehicles, view, many, few[near], empty)
    return rows


def _rows(vehicles: int, view: str, many: Pictures, few: Pictures, empty: Pictures) -> list[Row]:
    drawn = ", ".join(f"p{part} {_part(many.drawn_ms, part / 100):.1f}" for part in (50, 95, 99))
    apart = ", ".join(f"p{part} {_part(many.apart_ms, part / 100):.0f}" for part in (50, 99))
    return [
        Row(
            f"map: script per picture, {vehicles:,} vehicles, {view}",
            many.script_ms,
            "ms",
            few.script_ms,
            f"with {FEW} vehicles",
            TARGET_MS.get(vehicles),
            f"drawing alone {drawn} ms",
            less=True,
        ),
        Row(
            f"map: from picture to picture, p95, {vehicles:,} vehicles, {view}",
            _part(many.apart_ms, 0.95),
            "ms",
            _part(empty.apart_ms, 0.95),
            "an empty canvas with the same stream",
            note=f"{apart} ms; {len(many.drawn_ms)} pictures; painted without a graphics card",
            less=True,
        ),
    ]


def _panel(browser: Browser, house: House, span_s: float, near: bool) -> Pictures:
    """The management panel, at first sight or near."""
    page = profile(browser, house, house.session).new_page()
    page.add_init_script(f"({WATCH})()")
    page.goto(house.url)
    plant = page.locator("#plant-map")
    plant.wait_for()
    if near:
        for _ in range(NEAR_STEPS):
            plant.press("+")
    return _watched(page, span_s)


def _empty(browser: Browser, house: House, span_s: float) -> Pictures:
    page = profile(browser, house, house.session).new_page()
    page.goto(f"{house.url}/healthz")
    page.evaluate(WATCH)
    page.evaluate(EMPTY)
    return _watched(page, span_s)


def _watched(page: Page, span_s: float) -> Pictures:
    """The page's pictures of so many seconds; the page is closed."""
    page.wait_for_timeout(SETTLED_S * 1000)
    metrics = page.context.new_cdp_session(page)
    # Measured in processor time, which does not grow on a busy computer.
    metrics.send("Performance.enable", {"timeDomain": "threadTicks"})
    before_s = _script_s(metrics.send("Performance.getMetrics"))
    page.evaluate("pictures.length = 0")
    page.wait_for_timeout(span_s * 1000)
    pictures: list[tuple[float, float]] = page.evaluate("pictures.slice()")
    script_s = _script_s(metrics.send("Performance.getMetrics")) - before_s
    page.context.close()
    return Pictures(
        tuple(sorted(drawn for _, drawn in pictures)),
        tuple(sorted(later - earlier for (earlier, _), (later, _) in pairwise(pictures))),
        script_s * 1000 / len(pictures),
    )


def _script_s(answer: dict[str, Any]) -> float:
    return next(float(each["value"]) for each in answer["metrics"] if each["name"] == "ScriptDuration")


def _part(ascending: Sequence[float], part: float) -> float:
    """The nearest rank."""
    return ascending[min(len(ascending) - 1, int(part * len(ascending)))]
