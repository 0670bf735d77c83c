"""The shift report in a real browser: chosen, set against targets, printed on A4, and read by everybody."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from looks import Theme
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def factory(busy: Any) -> str:
    return str(busy.url)


def open_report(factory: str, open_page: OpenPage, **look: object) -> Page:
    """The report on the shift that goes on, once vehicles are in it."""
    page = open_page(f"{factory}/#shift", **look)
    expect(page.locator(".shift-states").first).to_be_attached()
    return page


def test_a_shift_is_found_by_the_figures_chosen_and_sent_as_an_address(
    factory: str, open_page: OpenPage
) -> None:
    page = open_page(f"{factory}/#kpis")
    page.get_by_role("link", name="Shift report").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Shift report")
    now = page.get_by_role("heading", level=1).inner_text()
    page.get_by_role("button", name="Shift before").click()
    expect(page).to_have_url(re.compile("from="))
    expect(page.get_by_role("heading", level=1)).not_to_have_text(now)
    # Of a time in which nothing ran no figure is made up.
    expect(page.locator("tr", has_text="Energy per transport").locator(".shift-value")).to_have_text("\u2013")
    before = page.get_by_role("heading", level=1).inner_text()
    page.reload()
    expect(page.get_by_role("heading", level=1)).to_have_text(before)
    page.go_back()
    expect(page.get_by_role("heading", level=1)).to_have_text(now)


def test_a_manager_sets_a_target_and_a_missed_one_says_so_in_words(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_report(factory, open_page)
    page.get_by_role("button", name="Targets …").click()
    # It is counted from the orders themselves, and not from the minutes that are written down of everything else.
    page.get_by_label("Orders delivered ≥").fill("1000000")
    page.get_by_label("Takeovers").fill("1000000")
    page.get_by_role("button", name="Save targets").click()
    row = page.locator("tr", has_text="Orders delivered").first
    expect(row).to_contain_text("missed")
    expect(row).to_contain_text("at least 1,000,000")
    expect(page.locator("tr", has_text="Takeovers").first).not_to_contain_text("missed")
    expect(page.locator(".shift-said")).to_contain_text("Look at: Orders delivered")
    page.keyboard.press("Escape")
    # What a figure means, by the keyboard.
    row = page.locator("tr", has_text="Machines making pieces")
    row.locator(".term").focus()
    expect(row.get_by_role("tooltip")).to_be_visible()
    expect(row.get_by_role("tooltip")).to_contain_text("ISO 22400-2")
    screenshot(page, "shift-report-missed")


def test_it_prints_on_pages_of_a4_without_buttons(factory: str, open_page: OpenPage, tmp_path: Path) -> None:
    page = open_report(factory, open_page, color_scheme="dark")
    page.emulate_media(media="print", color_scheme="dark")
    expect(page.get_by_role("button", name="Print or PDF")).to_be_hidden()
    assert page.evaluate("getComputedStyle(document.querySelector('.shift-paper')).backgroundColor") == (
        "rgb(255, 255, 255)"
    )
    pdf = page.pdf(path=tmp_path / "shift.pdf", prefer_css_page_size=True)
    # 210 x 297 mm in points, and all of it: one page would be the window alone.
    sizes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    assert {(round(float(width)), round(float(height))) for width, height in sizes} == {(595, 842)}
    assert 2 <= len(sizes) <= 5


def test_paper_names_its_day_and_zone_and_no_table_is_cut_on_a_small_screen(
    factory: str, open_page: OpenPage
) -> None:
    page = open_report(factory, open_page)
    expect(page.get_by_role("heading", level=1)).to_contain_text(
        re.compile(r"shift, \w+, \d+ \w+ 20\d\d, \d\d:\d\d")
    )
    zone = page.evaluate("Intl.DateTimeFormat().resolvedOptions().timeZone")
    expect(page.locator(".shift-head")).to_contain_text(f"times are in {zone}")
    page.wait_for_function(
        "() => [...document.querySelectorAll('.shift-scroll')].every(each => each.scrollWidth <= each.clientWidth)"
    )


@pytest.mark.parametrize(
    ("locale", "looks"),
    [
        ("en-GB", ((390, "light"), (1440, "light"))),
        ("de-DE", ((390, "dark"), (1024, "light"))),
        ("es-ES", ((1440, "dark"), (2560, "light"))),
    ],
)
def test_the_report_fits_and_can_be_read_by_everybody(
    factory: str,
    open_page: OpenPage,
    screenshot: Screenshot,
    locale: str,
    looks: tuple[tuple[int, Theme], ...],
) -> None:
    page = open_report(factory, open_page, locale=locale)
    for width, theme in looks:
        page.set_viewport_size({"width": width, "height": 900})
        page.emulate_media(color_scheme=theme)
        page.wait_for_function("() => document.documentElement.scrollWidth <= innerWidth")
        # It is audited as it is shown.
        screenshot(page, f"shift-report-{width}-{theme}-{locale[:2]}")


NOTHING_WIDE = """() => {
    const all = [...document.querySelectorAll(".shift-scroll")];
    return all.length > 0 && all.every(each => each.scrollWidth <= each.clientWidth);
}"""
"""There are lists, and none of them is wider than what is seen of it."""


@pytest.mark.parametrize("locale", ["en-GB", "de-DE", "es-ES"])
def test_on_a_narrow_telephone_nothing_of_it_is_scrolled_sideways_and_it_names_its_plant(
    factory: str, open_page: OpenPage, screenshot: Screenshot, locale: str
) -> None:
    page = open_report(factory, open_page, viewport={"width": 360, "height": 740}, locale=locale)
    said = {"en-GB": "Plant “Figure 1”", "de-DE": "Werk „Figure 1“", "es-ES": "Planta «Figure 1»"}
    expect(page.locator(".shift-paper")).to_contain_text(said[locale])
    # Its fonts may come after its figures.
    page.wait_for_function("() => document.documentElement.scrollWidth <= innerWidth")
    page.wait_for_function(NOTHING_WIDE)
    screenshot(page, f"shift-report-360-{locale}")
