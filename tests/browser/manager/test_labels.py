"""Names on the map of a large plant: no two stand in one another, however dense it is and wherever somebody looks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from drawn_words import Word, pictures_of, watch_words, words_of
from manager_kit import choose
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

SIZES_PX = ((1280, 800), (1920, 1080))

CHOSEN = ("", "ATV3", "ATV11", "ATV20", "M7")
"""What is looked at, a moment each: what the panel chooses by itself, two that are silent, one at work, a machine."""

STEP_S = 5.0

SEEN_LEAST = 1000
"""Words, over all looks: a map without names would hold anything."""

AGE = re.compile(r"\d+(\.\d)?\s(s|min)$")
"""How long ago a watched vehicle was heard, on the line to it."""


@pytest.fixture
def large(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """40 machines and 30 vehicles at work, many of them watched; two of the vehicles are silent."""
    dray = start_dray("--plant", "large", "--speed", "10", "--seed", "3", stepped=True)
    dray.advance(50.0)
    for atv in ("ATV3", "ATV11"):
        dray.ask("/api/faults", {"kind": "powered_off", "agent": atv})
    dray.advance(3.0)
    yield dray
    assert dray.stop() == 0, dray.output()


def overlapping(words: list[Word]) -> list[tuple[Word, Word]]:
    return [(one, other) for one, other in combinations(words, 2) if one.covers(other)]


@pytest.mark.slow
def test_no_two_names_on_the_map_of_a_large_plant_stand_in_one_another(
    large: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page("about:blank", visits=large.url)
    watch_words(page)
    page.goto(large.url)
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    page.get_by_role("button", name="Areas", exact=True).click()
    seen, ages, wrong = 0, 0, []
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
                ages += sum(AGE.match(each.text) is not None for each in words)
                wrong += [(width, zoom, *each) for each in overlapping(words)]
            screenshot(page, f"labels-{width}-{zoom}", audited=False)
    assert wrong == [], wrong[:12]
    assert seen >= SEEN_LEAST
    assert ages > 0
