"""What was, in a real browser: the plant at a moment of the past, who knew what, and no way to command anything there."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from complaints import Complaints
from looks import THEMES
from manager_kit import kept_moment
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def factory(busy: Any) -> str:
    return str(busy.url)


def open_past(busy: Any, open_page: OpenPage, **look: object) -> Page:
    """The plant as it was a little while ago."""
    page = open_page(f"{busy.url}/#replay/{kept_moment(busy)}", **look)
    expect(page.locator(".replay-map")).to_have_attribute("aria-busy", "false")
    return page


def test_the_past_is_shown_played_and_left_again(
    busy: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_past(busy, open_page)
    expect(page.locator(".replay-band")).to_contain_text("Nothing here can be commanded")
    expect(page.locator(".strip-row .doing").first).to_be_visible()
    assert page.evaluate("document.querySelectorAll('.replay canvas').length") == 3

    # One second back with the keyboard, and the address has that moment.
    moment = page.get_by_role("slider", name="Moment")
    before = float(moment.input_value())
    moment.focus()
    page.keyboard.press("ArrowLeft")
    expect(moment).not_to_have_value(str(before))
    expect(page).not_to_have_url(re.compile(re.escape(f"#replay/{before:.1f}")))
    address = page.evaluate("location.hash")

    # It goes on when it is told to.
    page.get_by_role("button", name="Play", exact=True).click()
    expect(moment).not_to_have_value(moment.input_value())
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()

    # What a vehicle knew.
    page.locator(".strip-row").filter(has_text="ATV1").get_by_role("button").first.click()
    expect(page.locator(".knows")).to_contain_text("What ATV1 knew")
    screenshot(page, "replay")

    # A link leads to the same moment, and one link leads back.
    page.goto(f"{factory}/{address}")
    expect(page.locator(".replay-map")).to_have_attribute("aria-busy", "false")
    page.get_by_role("link", name="Back to live").click()
    expect(page.get_by_role("heading", name="Plant", level=1)).to_be_attached()


def test_a_link_to_a_moment_shows_it_before_there_is_any_news(
    busy: Any, factory: str, open_page: OpenPage
) -> None:
    page = open_page(factory)
    # As the link has it: rounded, it may be a second later.
    moment_s = round(kept_moment(busy), 1)
    other = page.context.new_page()
    # The stream never begins: what time it is at the server is not known.
    other.route_web_socket("**/api/stream", lambda _socket: None)
    other.goto(f"{factory}/#replay/{moment_s:.1f}")
    expect(other.locator(".replay-map")).to_have_attribute("aria-busy", "false")
    expect(other.get_by_text("Nothing is kept of")).to_have_count(0)
    shown = other.evaluate(
        "s => new Intl.DateTimeFormat('en-GB', { timeStyle: 'medium' }).format(s * 1000)", moment_s
    )
    expect(other.get_by_role("main")).to_contain_text(shown)


def test_a_moment_of_which_nothing_is_kept_says_so(
    busy: Any, factory: str, open_page: OpenPage, complaints: Complaints
) -> None:
    page = open_past(busy, open_page)
    page.goto(f"{factory}/#replay/1")
    # Which day it is depends on the time zone, and that on the time of the day.
    expect(page.get_by_text(re.compile(r"Nothing is kept of \d"))).to_be_visible()
    expect(page.locator(".replay-map")).to_have_attribute("aria-busy", "false")
    # The browser tells of every 404 by itself, and of nothing else; none comes after the page is left.
    page.goto("about:blank")
    assert all("status of 404" in each for each in complaints)
    complaints.clear()


REGULARLY = """
window.regularly = [];
const real = window.setInterval;
window.setInterval = (work, ...more) => { window.regularly.push(work); return real(work, ...more); };
"""
"""Keeps what a page does regularly."""

LED_TO = """address => {
    location.hash = address;
    for (const work of window.regularly) work();
    return location.hash;
}"""
"""Leads to an address; what is done regularly comes before the page is told of that."""


def test_an_address_that_one_is_led_to_is_not_written_over_with_the_moment_shown(
    busy: Any, open_page: OpenPage
) -> None:
    page = open_page(busy.url)
    page.add_init_script(REGULARLY)
    page.goto(f"{busy.url}/#replay/{kept_moment(busy)}")
    page.reload()
    expect(page.locator(".replay-map")).to_have_attribute("aria-busy", "false")
    for moment in (kept_moment(busy, 20.0) - 10.0, kept_moment(busy, 20.0) - 5.0):
        address = f"#replay/{moment:.1f}"
        assert page.evaluate(LED_TO, address) == address
        expect(page.locator(".replay-map")).to_have_attribute("aria-busy", "false")


def test_the_past_fits_and_can_be_read_by_everybody(
    busy: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_past(busy, open_page)
    expect(page.locator(".strip-row .doing").first).to_be_visible()
    for width in (390, 1024, 1440):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_function("() => document.documentElement.scrollWidth <= innerWidth")
        for theme in THEMES:
            page.emulate_media(color_scheme=theme)
            # It is audited as it is shown.
            screenshot(page, f"replay-{width}-{theme}")


@pytest.mark.parametrize(("locale", "word"), [("de", "Zurück zu jetzt"), ("es", "Volver al presente")])
def test_the_past_speaks_every_language(
    busy: Any, factory: str, open_page: OpenPage, locale: str, word: str
) -> None:
    page = open_past(busy, open_page, locale=locale)
    expect(page.get_by_role("link", name=word)).to_be_visible()
