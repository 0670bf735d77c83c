"""The timelines of vehicles and machines: zoomed by buttons, keys and wheel, and led from one to the other by waits and takeovers."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from accessibility import violations
from manager_kit import BEFORE_S, kept_moment
from playwright.sync_api import Page, Route, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def factory(busy: Any) -> str:
    return str(busy.url)


LABELS = {
    "en-GB": ("Longer time", "waits for ATV3", "ATV1 takes it over", "Timeline of ATV2"),
    "de-DE": ("Längere Zeit", "wartet auf ATV3", "ATV1 übernimmt", "Zeitleiste von ATV2"),
    "es-ES": ("Más tiempo", "espera a ATV3", "ATV1 lo toma", "Cronología de ATV2"),
}


def spell(
    agent: str, doing: str, moment_s: float, from_s: float, until_s: float, **more: str
) -> dict[str, Any]:
    """What somebody did, told by how long before and after the moment."""
    blank = dict.fromkeys(("task", "item", "source", "destination", "other"), "")
    times = {"from_at_s": moment_s + from_s, "until_at_s": moment_s + until_s}
    return {"agent": agent, "doing": doing, **times, **blank, **more}


def a_story(moment_s: float) -> list[dict[str, Any]]:
    """ATV2 waits for ATV3, which falls silent with its load; ATV1 takes that over and brings it to M8.

    Whatever is led to is a moment that is kept.
    """
    return [
        spell("ATV2", "idle", moment_s, -60, -3),
        spell("ATV2", "waits", moment_s, -3, 30, task="M7-4", other="ATV3"),
        spell("ATV3", "carries", moment_s, -40, -1, task="M8-1", item="shaft", source="S5", destination="M8"),
        spell("ATV3", "silent", moment_s, -1, 60),
        spell("ATV1", "carries", moment_s, 0, 40, task="M8-1", item="shaft", source="S5", destination="M8"),
        spell("M8", "makes", moment_s, -60, 60, item="gear-unit-g2"),
    ]


def open_timeline(
    busy: Any, open_page: OpenPage, before_s: float = BEFORE_S, **look: Any
) -> tuple[Page, float]:
    """The page of the past with strips that the test tells, and so much kept before its moment."""
    page = open_page("about:blank", visits=busy.url, **look)
    moment_s = kept_moment(busy, before_s)

    def answer(route: Route) -> None:
        route.fulfill(json={"items": a_story(moment_s), "is_whole": True})

    page.route("**/api/spells?*", answer)
    page.goto(f"{busy.url}/#replay/{moment_s}")
    expect(page.locator(".replay-map")).to_have_attribute("aria-busy", "false")
    expect(page.locator(".strip-row .doing").first).to_be_visible(timeout=60_000)
    return page, moment_s


@pytest.mark.parametrize("locale", LABELS)
def test_a_wait_leads_to_whom_it_was_for_and_a_takeover_to_its_other_side(
    busy: Any, open_page: OpenPage, screenshot: Screenshot, locale: str
) -> None:
    page, _ = open_timeline(busy, open_page, locale=locale, viewport={"width": 1440, "height": 900})
    _, waits, taken, _ = LABELS[locale]
    page.locator(".strip-row").get_by_role("button", name="ATV2", exact=True).click()
    story = page.locator(".spell-story")
    story.get_by_role("button", name=waits).click()
    expect(page.locator(".strip-row.chosen")).to_contain_text("ATV3")
    screenshot(page, f"timeline-{locale}")
    story.get_by_role("button", name=taken).click()
    expect(page.locator(".strip-row.chosen")).to_contain_text("ATV1")
    # From the vehicle to the machine whose dock it goes to: the strips of machines are shown then.
    story.get_by_role("button", name=re.compile(r"M8")).click()
    expect(page.locator(".strip-row.chosen")).to_contain_text("M8")
    assert violations(page) == []


def test_it_is_zoomed_by_buttons_by_keys_and_by_the_wheel(busy: Any, open_page: OpenPage) -> None:
    # A step of the arrow keys leads back by a sixtieth of what is shown.
    page, _ = open_timeline(busy, open_page, before_s=720 / 60)
    longer = page.get_by_role("button", name="Longer time")
    shorter = page.get_by_role("button", name="Shorter time")
    span = page.get_by_role("group", name="How long the strips are")
    pressed = span.locator("[aria-pressed=true]")
    expect(pressed).to_have_text("12 min")

    shorter.click()
    expect(pressed).to_have_count(0)
    longer.click()
    expect(pressed).to_have_text("12 min")

    strips = page.get_by_role("group", name="What everybody did; arrow keys")
    strips.focus()
    for _ in range(2):
        page.keyboard.press("-")
    expect(pressed).to_have_text("1 h")
    page.keyboard.press("+")
    page.keyboard.press("+")
    expect(pressed).to_have_text("12 min")

    strips.hover()
    page.keyboard.down("Control")
    page.mouse.wheel(0, -120)
    page.keyboard.up("Control")
    expect(pressed).to_have_count(0)

    moment = page.get_by_role("slider", name="Moment")
    before = moment.input_value()
    strips.focus()
    page.keyboard.press("ArrowLeft")
    expect(moment).not_to_have_value(before)


def test_a_card_leads_to_its_timeline(busy: Any, factory: str, open_page: OpenPage) -> None:
    page = open_page(f"{factory}/#plant?at=atv:ATV2")
    kept_moment(busy)
    page.get_by_role("link", name="Timeline of ATV2").click()
    expect(page.locator(".strip-row.chosen")).to_contain_text("ATV2")
