"""The field *Find*: what is in sight already stays where it is, and what is not comes into sight."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drawn_words import Word, pictures_of, watch_words, words_of
from manager_kit import choose
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]

NEAR = 5
"""Steps of the button, until most of the plant is out of sight."""


SHIFT_PX = 20.0
"""A map that is not moved fits itself into the page, whose cards change, and draws what is chosen larger."""


SETTLED = """() => {
    const map = document.querySelector("#plant-map");
    const isThere = document.querySelector(".card.factory") && document.querySelector(".publish") && document.fonts.status === "loaded";
    const found = window.drawnWords("#plant-map").find(([text]) => text === "M1");
    if (!isThere || !found || map.querySelector("canvas").clientWidth !== map.clientWidth) return null;
    return [found, map.clientWidth, map.clientHeight];
}"""
"""What is drawn of a machine, and how large the map is, at one moment: once all cards are there, and the map fits them."""


def place_of(page: Page, machine: str, *, after: int | None = None) -> Word | None:
    return next((word for word in words_of(page, after=after) if word.text == machine), None)


def test_find_moves_the_map_only_to_what_is_out_of_sight(quiet: Any, open_page: OpenPage) -> None:
    page = open_page("about:blank", visits=quiet.url)
    watch_words(page)
    page.goto(quiet.url)
    page.wait_for_load_state("networkidle")
    told, width, height = page.wait_for_function(SETTLED).json_value()
    before = Word(*told)
    assert abs((before.left + before.right) / 2 - width / 2) > 3 * SHIFT_PX, "else nothing is shown"
    drawn = pictures_of(page)
    choose(page, "M1")
    expect(page.locator(".card.machine")).to_contain_text("M1")
    after = place_of(page, "M1", after=drawn)
    assert after is not None
    assert abs(after.left - before.left) < SHIFT_PX
    assert abs(after.top - before.top) < SHIFT_PX
    # Near to what is in the middle, it is out of sight.
    for _ in range(NEAR):
        page.get_by_role("button", name="Zoom in").click()
    page.wait_for_function("() => !window.drawnWords('#plant-map').some(([text]) => text === 'M2')")
    choose(page, "M2")
    page.wait_for_function("() => window.drawnWords('#plant-map').some(([text]) => text === 'M2')")
    found = place_of(page, "M2")
    assert found is not None
    assert 0 <= found.left < found.right <= width
    assert 0 <= found.top < found.bottom <= height


def test_the_menu_of_a_person_leads_to_the_page_of_an_operator(quiet: Any, open_page: OpenPage) -> None:
    page = open_page(quiet.url)
    page.locator("button.person").click()
    page.get_by_role("link", name="Operator").click()
    page.wait_for_url(f"{quiet.url}/operator")
    expect(page.locator("#stops")).to_be_visible()
