"""What holds for every page alike: themes, languages, zoom, and the keyboard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from accessibility import violations
from looks import LOCALES, THEMES, WIDTHS_PX, in_every_look
from playwright.sync_api import Page, expect
from variants import variants

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@dataclass(frozen=True, slots=True)
class Shown:
    """One page.

    Attributes:
        path: where it is.
        who: is logged in, by the beginning of the name; None for nobody.
        ready: a selector of something that is there when the page has all that it shows.
    """

    path: str
    who: str | None
    ready: str


PAGES = {
    "management": Shown("/", "manager", "#plant-map canvas"),
    "operator": Shown("/operator", "operator", "canvas"),
    "login": Shown("/login", None, "h1"),
    "login-operator": Shown("/login?as=operator", None, "h1"),
    "station": Shown("/login/station", "operator", "h1"),
    "editor": Shown("/editor", "manager", "h1"),
}
"""The customer's page has tests of its own."""


@pytest.fixture
def factory(busy: Any) -> Any:
    """A factory in which there is something to see."""
    return busy


def opened(factory: Any, open_page: OpenPage, shown: Shown, **options: Any) -> Page:
    who = None if shown.who is None else next(name for name in factory.links if name.startswith(shown.who))
    page = open_page(factory.url + shown.path, who=who, **options)
    page.locator(shown.ready).first.wait_for()
    return page


@pytest.mark.parametrize("language", variants(LOCALES))
@pytest.mark.parametrize("name", PAGES)
def test_every_page_is_itself_in_every_language_and_theme(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, name: str, language: str
) -> None:
    page = opened(factory, open_page, PAGES[name], locale=LOCALES[language])
    for theme in THEMES:
        page.emulate_media(color_scheme=theme)
        expect(page.locator("html")).to_have_attribute("lang", language)
        screenshot(page, f"{name}-{language}-{theme}")


CHOOSE_A_FILE = {"en": "Choose a file…", "de": "Datei wählen…", "es": "Elegir un archivo…"}


@pytest.mark.parametrize("language", LOCALES)
def test_the_editor_asks_for_a_file_in_the_language_that_is_chosen(
    factory: Any, open_page: OpenPage, language: str
) -> None:
    page = opened(factory, open_page, PAGES["editor"], locale=LOCALES[language])
    button, field = page.locator(".ed-file .button"), page.locator("input[type=file]")
    expect(button).to_have_text(CHOOSE_A_FILE[language])
    # A browser's own button, in the browser's language, is not to be seen.
    assert field.evaluate("it => it.getBoundingClientRect().width") <= 1
    # Whoever comes to it with the keys sees where the focus is.
    field.focus()
    assert button.evaluate("it => getComputedStyle(it).outlineStyle") == "solid"


DOCS = Shown("/api/docs", "manager", "h1")
"""The documentation of the API is in English only."""


@pytest.mark.parametrize("name", [*PAGES, "docs"])
def test_every_page_fits_and_is_fit_for_all_at_every_width(
    factory: Any, open_page: OpenPage, name: str
) -> None:
    page = opened(factory, open_page, PAGES.get(name, DOCS), locale="es-ES")
    for width in WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        assert violations(page) == [], width


AUDITED_PX = (390, 800, 1440)
"""Each view is audited as a telephone shows it, as a tablet upright does, and as a laptop."""

LED_TO = ("alerts", "transports", "recurring", "shift", "people")
"""Views that are not in the menu; the past has tests of its own, once something of it is kept."""


@in_every_look
@pytest.mark.parametrize("width", WIDTHS_PX)
def test_every_view_of_the_management_panel_fits_and_is_fit_for_all(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str, width: int
) -> None:
    look = {"locale": LOCALES[language], "color_scheme": theme, "viewport": {"width": width, "height": 900}}
    page = opened(factory, open_page, PAGES["management"], **look)
    addresses = (
        page.get_by_role("navigation")
        .get_by_role("link")
        .evaluate_all("all => all.map(a => a.hash).filter(Boolean)")
    )
    assert len(addresses) >= 6
    for address in (*addresses, *(f"#{name}" for name in LED_TO)):
        page.evaluate("address => { location.hash = address; }", address)
        if address in addresses:
            expect(page.locator(f'nav a[href="{address}"]')).to_have_attribute("aria-current", "page")
        expect(page.locator("[aria-busy=true]")).to_have_count(0)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), address
        # In between the same elements stand in the same colours: blocks as on a telephone, tables as on a laptop.
        name = f"management-{address.removeprefix('#')}-{width}-{language}-{theme}"
        screenshot(page, name, audited=width in AUDITED_PX)


OUTSIDE = """() => [...document.querySelectorAll(".stacked :is(th, td)")]
    .filter((each) => each.checkVisibility() && each.closest("tbody"))
    .filter((each) => each.getBoundingClientRect().right > innerWidth || each.scrollWidth > each.clientWidth + 1)
    .map((each) => each.textContent.slice(0, 40))"""


def test_on_a_telephone_every_cell_of_a_list_stands_in_the_window_and_says_its_columns_name(
    factory: Any, open_page: OpenPage
) -> None:
    page = opened(
        factory, open_page, PAGES["management"], locale="de-DE", viewport={"width": 390, "height": 844}
    )
    for address in ("#orders", "#fleet", "#watch", "#audit", "#people"):
        page.evaluate("address => { location.hash = address; }", address)
        rows = page.locator(".stacked tbody tr")
        rows.first.wait_for()
        expect(page.locator("[aria-busy=true]")).to_have_count(0)
        assert page.evaluate(OUTSIDE) == [], address
        said = rows.first.locator("td:not(:empty):not(:has(.tick))").first
        names = page.locator(".stacked thead th").all_text_contents()
        head = said.evaluate("each => getComputedStyle(each, '::before').content")
        assert head.strip('"') in names, address


def test_on_a_telephone_no_long_name_makes_the_page_wider(factory: Any, open_page: OpenPage) -> None:
    page = opened(factory, open_page, PAGES["management"], viewport={"width": 390, "height": 844})
    name = page.locator(".orders .order .clip").first
    name.evaluate("each => { each.textContent = 'Hinterhuber GmbH & Co. KG '.repeat(6); }")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    widths = page.locator(".giving > .card").evaluate_all("all => all.map((each) => each.offsetWidth)")
    assert len(widths) >= 2
    assert len(set(widths)) == 1


def test_what_is_only_for_screen_readers_makes_no_page_longer(factory: Any, open_page: OpenPage) -> None:
    page = opened(factory, open_page, PAGES["management"], viewport={"width": 1440, "height": 900})
    # As many alerts as a bad day has: their levels are said, and not seen.
    page.locator(".column.left").evaluate(
        """left => {
            const list = document.createElement("ul");
            list.className = "inbox-list";
            list.style.height = "80px";
            list.innerHTML = '<li class="inbox-line"><p><span class="unseen">Alarm</span> x</p><button>Take</button></li>'.repeat(60);
            left.append(list);
        }"""
    )
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight")


@pytest.mark.parametrize("name", variants(PAGES, "operator"))
def test_at_200_percent_nothing_has_to_be_scrolled_sideways(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, name: str
) -> None:
    # What a browser makes of 1,280 x 800 at this zoom (WCAG 1.4.4 and 1.4.10).
    zoomed = {"viewport": {"width": 640, "height": 400}, "device_scale_factor": 2}
    page = opened(factory, open_page, PAGES[name], **zoomed)
    assert page.evaluate("document.documentElement.scrollWidth") <= 640
    screenshot(page, f"{name}-at-200-percent", whole=True)


REACHABLE = """() => {
    const all = [...document.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex='0']")];
    window.reachable = all.filter((each) => !each.disabled && each.tabIndex >= 0 && each.checkVisibility());
    return window.reachable.length;
}"""

FOCUSED = """() => {
    const here = document.activeElement;
    // A box to tick is drawn by what stands beside it in its label.
    const drawn = [here, ...(here.closest("label")?.children ?? [])].map((each) => getComputedStyle(each));
    const box = here.getBoundingClientRect();
    return {
        index: window.reachable.indexOf(here),
        name: here === document.body ? "" : here.outerHTML.slice(0, 120),
        ringed: drawn.some((style) => style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2),
        inSight: box.bottom > 0 && box.top < innerHeight && box.right > 0 && box.left < innerWidth,
    };
}"""


@pytest.mark.parametrize("name", variants(PAGES))
def test_everything_that_can_be_used_is_reached_by_keyboard_and_seen_to_be(
    factory: Any, open_page: OpenPage, name: str
) -> None:
    page = opened(factory, open_page, PAGES[name])
    reachable = page.evaluate(REACHABLE)
    assert reachable > 0
    reached: set[int] = set()
    # Lists may grow meanwhile; nothing that was there may be passed over for that.
    for _ in range(2 * reachable):
        page.keyboard.press("Tab")
        focused = page.evaluate(FOCUSED)
        if not focused["name"]:
            # All round once: what comes before the field that was focused at first comes now.
            continue
        reached.add(focused["index"])
        assert focused["ringed"], focused
        assert focused["inSight"], focused
    names = page.evaluate(
        "indexes => indexes.map((index) => window.reachable[index]).filter((each) => each.isConnected)"
        ".map((each) => each.outerHTML.slice(0, 120))",
        sorted(set(range(reachable)) - reached),
    )
    assert names == []
