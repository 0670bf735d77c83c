"""Names on the map of a large plant: no two stand in one another, however dense it is and wherever somebody looks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from math import dist
from pathlib import Path
from typing import Any

import pytest
from drawn_words import overlapping, pictures_of, watch_words, words_of
from manager_kit import choose
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

SIZES_PX = ((1280, 800), (1920, 1080))

CHOSEN = ("", "ATV3", "ATV11", "ATV20", "M7")
"""What is looked at, a moment each: what the panel chooses by itself, two that are silent, one at work, a machine."""

STEP_S = 5.0

SILENT_S = 20.0
"""Until all are at work, and two have been silent for long."""

SEEN_LEAST = 1000
"""Words, over all looks: a map without names would hold anything."""

AGE = re.compile(r"\d+(\.\d)?\s(s|min)$")
"""How long ago a watched vehicle was heard, on the line to it."""

FAR_M = 25.0
"""From one that watches to the one it watches: on a shorter line is no room for an age."""

AGE_IS_DRAWN = """age => window.drawnWords("#plant-map").some(([text]) => new RegExp("^" + age).test(text))"""


@pytest.fixture
def large(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """40 machines and 30 vehicles, whose first transports have just been given, each with its watch.

    Soon all of them are at work, and nobody is left to watch.
    """
    dray = start_dray("--plant", "large", "--speed", "10", "--seed", "3", stepped=True)
    dray.advance_until(lambda: watched_from_afar(dray)[0] >= FAR_M, step_s=1.0)
    yield dray
    assert dray.stop() == 0, dray.output()


def watched_from_afar(dray: Any) -> tuple[float, str]:
    """How far the watched vehicle that is farthest from its watch is from it, and which it is."""
    at = {atv["id"]: (atv["x_m"], atv["y_m"]) for atv in dray.ask("/api/atvs")["items"]}
    pairs = [
        (task["primary"], task["secondary"])
        for task in dray.ask("/api/tasks?state=contracted")["items"]
        if task["secondary"]
    ]
    return max(((dist(at[one], at[other]), one) for one, other in pairs), default=(0.0, ""))


@pytest.mark.slow
def test_no_two_names_on_the_map_of_a_large_plant_stand_in_one_another(
    large: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page("about:blank", visits=large.url)
    watch_words(page)
    page.goto(large.url)
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    page.get_by_role("button", name="Areas", exact=True).click()
    seen, wrong = 0, []
    _, name = watched_from_afar(large)
    for width, height in SIZES_PX:
        before = pictures_of(page)
        page.set_viewport_size({"width": width, "height": height})
        choose(page, name)
        expect(page.locator(".card.atv h2")).to_contain_text(name)
        words_of(page, after=before)
        page.wait_for_function(AGE_IS_DRAWN, arg=AGE.pattern)
        wrong += [(width, "watched", *each) for each in overlapping(words_of(page))]
        screenshot(page, f"labels-{width}-watched", audited=False)
    for atv in ("ATV3", "ATV11"):
        large.ask("/api/faults", {"kind": "powered_off", "agent": atv})
    large.advance(SILENT_S)
    for width, height in SIZES_PX:
        page.set_viewport_size({"width": width, "height": height})
        for zoom in ("all", "near"):
            page.get_by_role("button", name="Show the whole plant" if zoom == "all" else "Zoom in").click()
            for name in CHOSEN:
                if name:
                    choose(page, name)
                before = pictures_of(page)
                large.advance(STEP_S)
                words = words_of(page, after=before)
                seen += len(words)
                wrong += [(width, zoom, *each) for each in overlapping(words)]
            screenshot(page, f"labels-{width}-{zoom}", audited=False)
    assert wrong == [], wrong[:12]
    assert seen >= SEEN_LEAST
