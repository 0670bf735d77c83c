"""One selection in a real browser: all that belongs to it, in the address, gone back and forward over, sent, and followed."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from looks import LOCALES, WIDTHS_PX, in_every_look
from manager_kit import choose
from playwright.sync_api import Locator, Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def factory(busy: Any) -> str:
    return str(busy.url)


def _story(page: Page) -> Locator:
    return page.get_by_role("region", name="What is chosen")


def _card(page: Page, agent: str) -> Locator:
    """The card of a machine or a vehicle, on the right."""
    return page.locator(".column.right").get_by_role("region", name=re.compile(rf"^{agent}\b"))


def _of(page: Page, part: str) -> str:
    """What the story says of its vehicle, say."""
    said = _story(page).locator("dl > div").filter(has=page.get_by_text(part, exact=True))
    return said.locator("dd .link").first.inner_text()


def test_what_is_chosen_is_in_the_address_and_the_browser_goes_back_over_it(
    factory: str, open_page: OpenPage
) -> None:
    page = open_page(factory)
    choose(page, "ATV3")
    expect(page).to_have_url(re.compile(r"#plant\?at=atv%3AATV3$"))
    expect(_story(page).get_by_role("button", name="ATV3")).to_be_visible()
    choose(page, "M5")
    expect(page).to_have_url(re.compile(r"at=machine%3AM5$"))
    expect(_card(page, "M5")).to_be_visible()
    page.go_back()
    expect(page).to_have_url(re.compile(r"at=atv%3AATV3$"))
    expect(_card(page, "ATV3")).to_be_visible()
    page.go_forward()
    expect(page).to_have_url(re.compile(r"at=machine%3AM5$"))
    expect(_card(page, "M5")).to_be_visible()
    # Another view, and back to the plant: it is still what was chosen.
    page.get_by_role("link", name="Fleet").click()
    page.get_by_role("link", name="Plant").click()
    expect(page).to_have_url(re.compile(r"#plant\?at=machine%3AM5$"))


def test_a_link_that_was_sent_shows_the_same_in_another_browser(factory: str, open_page: OpenPage) -> None:
    page = open_page(factory, permissions=["clipboard-read", "clipboard-write"])
    choose(page, "M5")
    expect(page).to_have_url(re.compile(r"at=machine%3AM5$"))
    _story(page).get_by_role("button", name="Copy link").click()
    expect(_story(page).get_by_role("status")).to_have_text("Copied")
    sent = page.evaluate("navigator.clipboard.readText()")
    assert sent == page.url
    other = open_page(sent)
    expect(_card(other, "M5")).to_be_visible()
    expect(other).to_have_url(sent)
    expect(_story(other).get_by_role("button", name="M5", exact=True)).to_be_visible()


def test_a_link_that_names_what_is_not_there_says_so(factory: str, open_page: OpenPage) -> None:
    page = open_page(factory)
    page.goto(f"{factory}/#plant?at=atv%3ANOPE")
    expect(_story(page)).to_have_text("Nothing in this plant is called NOPE.")
    page.goto(f"{factory}/#plant?at=order%3A{'x' * 3000}")
    expect(_story(page).get_by_role("button", name="Follow")).to_be_visible()
    assert page.locator("body").evaluate("body => body.scrollWidth <= body.clientWidth")
    box = _story(page).bounding_box()
    assert box is not None
    assert box["height"] < 100
    choose(page, "ATV3")
    expect(_story(page).get_by_role("button", name="ATV3")).to_be_visible()


def test_newest_hides_what_is_chosen_only_until_something_is_chosen(
    factory: str, open_page: OpenPage
) -> None:
    page = open_page(f"{factory}/#plant?at=atv%3AATV3")
    expect(_card(page, "ATV3")).to_be_visible()
    newest = page.get_by_role("group", name="Shown auction").get_by_role("button", name="Newest")
    newest.click()
    expect(newest).to_have_attribute("aria-pressed", "true")
    choose(page, "ATV4")
    expect(newest).to_have_attribute("aria-pressed", "false")
    newest.click()
    # The same once more is a choice, too.
    choose(page, "ATV4")
    expect(newest).to_have_attribute("aria-pressed", "false")


def test_a_transport_chosen_in_a_list_is_a_whole_story_and_is_followed(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{factory}/#tasks?state=contracted&kind=transport")
    rows = page.locator("tbody tr")
    expect(rows.first).to_be_visible()
    rows.first.get_by_role("button").first.click()
    story = _story(page)
    expect(story).to_contain_text("Transport")
    expect(story).to_contain_text("Machine")
    # What the story names is in the cards and above the bids.
    expect(_card(page, _of(page, "Machine"))).to_be_visible()
    expect(_card(page, _of(page, "Vehicle"))).to_be_visible()
    expect(page.get_by_role("region", name=f"Auction {_of(page, 'Transport')}")).to_be_visible()
    follow = story.get_by_role("button", name="Follow")
    follow.click()
    expect(follow).to_have_attribute("aria-pressed", "true")
    expect(page).to_have_url(re.compile("follow=yes"))
    screenshot(page, "story")
    # Who chooses something on the map moves nothing; whoever moves it by hand follows no longer.
    floor = page.locator("#plant-map")
    floor.click(position={"x": 4, "y": 4})
    expect(follow).to_have_attribute("aria-pressed", "true")
    box = floor.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 20, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(box["x"] + 80, box["y"] + 90, steps=4)
    page.mouse.up()
    expect(follow).to_have_attribute("aria-pressed", "false")
    follow.click()
    expect(follow).to_have_attribute("aria-pressed", "true")
    floor.focus()
    page.keyboard.press("ArrowLeft")
    expect(follow).to_have_attribute("aria-pressed", "false")


def test_an_order_is_shown_on_the_plant_with_what_is_done_for_it(factory: str, open_page: OpenPage) -> None:
    page = open_page(factory)
    reference = page.locator(".order .small .clip").first.inner_text().split(" · ")[0]
    page.locator(".order .link").first.click()
    page.get_by_role("button", name="Show on the plant").click()
    expect(page).to_have_url(re.compile(r"#plant\?at=order%3AO"))
    link = _story(page).get_by_role("link", name=reference)
    expect(link).to_be_visible()
    page.go_back()
    expect(page).to_have_url(re.compile(r"#orders/O"))


def test_the_tour_has_three_steps_is_skipped_for_good_and_found_again(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory, first_time=True)
    tour = page.get_by_role("complementary", name="Tour")
    expect(tour).to_contain_text("1 of 3")
    screenshot(page, "tour")
    tour.get_by_role("button", name="Next").click()
    expect(tour).to_contain_text("2 of 3")
    tour.get_by_role("button", name="Skip").click()
    expect(tour).to_have_count(0)
    page.reload()
    expect(_story(page)).to_be_visible()
    expect(tour).to_have_count(0)
    # From any view: what it tells of is the plant.
    page.get_by_role("link", name="Fleet").click()
    page.get_by_role("button", name="Management").click()
    page.get_by_role("button", name="Show the tour").click()
    for step in (1, 2, 3):
        expect(tour).to_contain_text(f"{step} of 3")
        screenshot(page, f"tour-{step}")
        tour.get_by_role("button", name="Next" if step < 3 else "Done").click()
    expect(tour).to_have_count(0)


def test_words_of_the_trade_are_explained_under_the_pointer_and_on_the_keyboards_way(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory)
    word = page.get_by_text("transport, 95 %")
    says = page.get_by_role("tooltip").filter(has_text="95 of 100")
    word.focus()
    expect(says).to_be_visible()
    screenshot(page, "term")
    page.keyboard.press("Escape")
    expect(says).to_be_hidden()
    page.get_by_text("transport, 50 %").hover()
    expect(page.get_by_role("tooltip").filter(has_text="Half of the last")).to_be_visible()
    page.mouse.move(0, 0)
    expect(page.get_by_role("tooltip")).to_have_count(0)


def test_the_legend_is_opened_and_closed_with_the_keyboard(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory)
    legend = page.get_by_role("button", name="Legend")
    legend.focus()
    page.keyboard.press("Enter")
    signs = page.get_by_role("list", name="What the signs of the map mean")
    expect(signs).to_contain_text("secondary of the chosen vehicle")
    screenshot(page, "legend")
    page.keyboard.press("Escape")
    expect(signs).to_be_hidden()
    expect(legend).to_be_focused()


@in_every_look
def test_the_story_fits_every_width(
    factory: str, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str
) -> None:
    page = open_page(
        f"{factory}/#plant?at=machine%3AM5", first_time=True, locale=LOCALES[language], color_scheme=theme
    )
    expect(page.locator(".story dl")).to_be_visible()
    expect(page.locator(".tour")).to_be_visible()
    for width in WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        screenshot(page, f"story-{language}-{theme}-{width}")


def _is_watched(dray: Any) -> bool:
    """Whether somebody stands by for a transport."""
    tasks = dray.ask("/api/tasks?state=contracted")["items"]
    return any(task["secondary"] for task in tasks)


UNDER_BUTTONS = """story => {
    const buttons = [...story.querySelectorAll(".story-acts button")].map(each => each.getBoundingClientRect());
    return [...story.querySelectorAll("dt, dd > *")].filter(each => {
        const { bottom, left, right, top } = each.getBoundingClientRect();
        return buttons.some(button => left < button.right && button.left < right && top < button.bottom && button.top < bottom);
    }).map(each => each.textContent);
}"""
"""What stands under its buttons."""

CUT_SHORT = """story => [...story.querySelectorAll("dl > div:not(:last-child) :is(dt, .link)")]
    .filter(each => each.scrollWidth > each.clientWidth).map(each => each.textContent)"""
"""What ends in three dots, but for the last part: an order may have a long name."""

LINE_PX = 56
"""With the names of its parts above them."""

TWO_LINES_PX = 96

BESIDE_THE_MAP_PX = (800, 1024, 1181, 1200, 1240, 1280, 1440)


@pytest.mark.parametrize("language", LOCALES)
def test_the_whole_story_stands_in_one_line_and_nothing_of_it_under_its_buttons(
    busy: Any, factory: str, open_page: OpenPage, screenshot: Screenshot, language: str
) -> None:
    busy.advance_until(lambda: _is_watched(busy))
    page = open_page(f"{factory}/#tasks?state=contracted&kind=transport", locale=LOCALES[language])
    watched = page.locator("tbody tr").filter(has=page.locator("td:nth-of-type(6)", has_text="ATV")).first
    watched.locator("th .link").click()
    story = page.locator(".story")
    expect(story.locator("dl > div").nth(2)).to_be_visible()
    for width_px in BESIDE_THE_MAP_PX:
        page.set_viewport_size({"width": width_px, "height": 900})
        assert story.locator("dl > div").evaluate_all(TOPS) == 1, width_px
        assert story.evaluate(UNDER_BUTTONS) == [], width_px
        assert story.evaluate(CUT_SHORT) == [], width_px
        height = story.evaluate("it => it.getBoundingClientRect().height")
        # On a tablet its buttons have a line of their own, whatever is chosen.
        assert height <= (LINE_PX if width_px >= 1181 else TWO_LINES_PX), width_px
        screenshot(page, f"story-whole-{language}-{width_px}")


TOPS = "all => new Set(all.map(each => each.getBoundingClientRect().top)).size"
