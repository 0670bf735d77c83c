"""Each card of the plant's view shows some of its rows, in every language and on low screens."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from looks import CUT, LOCALES
from playwright.sync_api import Locator, Page, expect

SIZES_PX = ((1440, 900), (1024, 768))
"""A laptop, on which nothing scrolls, and a tablet, whose page does."""

ROWS_IN_SIGHT = """(card) => {
  const inside = (row) => {
    const { bottom, top } = row.getBoundingClientRect();
    for (let around = row.parentElement; around !== document.body; around = around.parentElement) {
      if (getComputedStyle(around).overflowY === "visible") continue;
      const clip = around.getBoundingClientRect();
      if (top < clip.top - 0.5 || bottom > clip.bottom + 0.5) return false;
    }
    return top >= 0 && bottom <= innerHeight + 0.5;
  };
  return [...card.querySelectorAll("li.order, .kpi, .status-row, dt, .bid, .field")].filter(inside).length;
}"""
"""How many rows of a card are whole within it, within what scrolls around it, and within the window."""


SMALL_LAPTOPS_PX = (1181, 1200, 1210, 1240, 1280, 1310, 1340)

ON_TOP = """(button) => {
  const { left, top, height, width } = button.getBoundingClientRect();
  return button.contains(document.elementFromPoint(left + width / 2, top + height / 2));
}"""

ACTS_NOT_WHOLE = """(card, scrolls) => [...card.querySelectorAll(".chosen-acts > button")].flatMap(button => {
    if (scrolls) button.scrollIntoView({ behavior: "instant", block: "center" });
    const inside = button.getBoundingClientRect();
    const { bottom, left, right, top } = card.getBoundingClientRect();
    const within = inside.top >= Math.max(top, 0) && inside.bottom <= Math.min(bottom, innerHeight)
        && inside.left >= left && inside.right <= right;
    const over = document.elementFromPoint(inside.left + inside.width / 2, inside.top + inside.height / 2);
    return within && button.contains(over) ? [] : [`${button.textContent} ${inside.top}-${inside.bottom} of ${top}-${bottom}`];
})"""
"""The buttons that are not whole within their card and the window, or are covered.

At one moment: the card grows while its timeline is loaded, by which a page that was scrolled is moved.
"""

HEAD_APART = """card => {
    const [head, body] = [".card-head", ".card-body"].map(part => card.querySelector(part));
    const lowest = Math.max(...[...head.children].map(each => each.getBoundingClientRect().bottom));
    return lowest <= body.getBoundingClientRect().top + 0.5;
}"""
"""Whether all of a card's head is above what the card says."""

SHOWN_OVER = (
    """(icon, field) => Number(getComputedStyle(icon).zIndex) > Number(getComputedStyle(field).zIndex)"""
)
"""Not by what lies at that point: a sign lets a pointer through."""

LAPTOPS_PX = (
    (1440, 900),
    (1181, 800),
    (1200, 800),
    (1240, 800),
    (1280, 800),
    (1366, 768),
    (1536, 864),
    (1920, 1080),
    (2560, 1440),
)

TABLETS_PX = ((800, 1280), (1024, 768), (1100, 800), (1180, 820))
"""Upright and lying; the page scrolls."""

ONE_LINE = """() => {
  const head = document.querySelector(".map-head");
  const boxes = [...document.querySelectorAll(".map .chip")].map(chip => chip.getBoundingClientRect());
  return new Set(boxes.map(box => box.top)).size === 1
    && boxes.at(-1).right <= head.getBoundingClientRect().right && head.scrollWidth <= head.clientWidth;
}"""

ROWS_CUT = """(body) => {
  const clip = body.getBoundingClientRect();
  return [...body.querySelectorAll("li.order")].filter((row) => {
    const { bottom, top } = row.getBoundingClientRect();
    return top < clip.bottom - 1 && bottom > clip.bottom + 1;
  }).map((row) => row.textContent);
}"""
"""Orders of which a part is in sight."""

STANDS_OUT = """head => Math.max(...[...head.querySelectorAll("*")].map(each => each.getBoundingClientRect().right))
  - head.getBoundingClientRect().right"""
"""Pixels by which something stands out of the head of the map."""

LEAST_APART = """chips => Math.min(...chips.slice(1).map((chip, index) =>
  chip.getBoundingClientRect().left - chips[index].getBoundingClientRect().right))"""
"""Pixels between two layers."""

APART_PX = 4

TOPS = "all => new Set(all.map(each => each.getBoundingClientRect().top)).size"


@pytest.mark.parametrize("language", LOCALES)
def test_on_a_laptop_layers_are_one_line_no_figure_is_cut_and_the_field_find_opens(
    busy: Any, open_page: Callable[..., Page], screenshot: Callable[..., Path], language: str
) -> None:
    page = open_page(busy.url, viewport={"width": 1440, "height": 900}, locale=LOCALES[language])
    expect(page.locator(".factory .duty-row")).to_be_visible()
    chips, field = page.locator(".map .chip"), page.locator(".finder input")
    for width_px, height_px in LAPTOPS_PX:
        page.set_viewport_size({"width": width_px, "height": height_px})
        assert chips.evaluate_all(TOPS) == 1, width_px
        # Cards beside it come and go with the stream.
        page.wait_for_function(f"() => ({CUT})(document.querySelector('.factory')).length === 0")
        line = chips.first.bounding_box()
        field.focus()
        box = field.bounding_box()
        assert box is not None
        assert box["width"] >= 110, width_px
        assert chips.first.bounding_box() == line, "nothing moves by it"
        if width_px == 1280:
            screenshot(page, f"laptop-{language}")
        field.blur()


@pytest.mark.parametrize("language", LOCALES)
def test_on_a_small_laptop_layers_stand_apart_and_no_order_and_no_strip_is_cut(
    busy: Any, open_page: Callable[..., Page], screenshot: Callable[..., Path], language: str
) -> None:
    page = open_page(f"{busy.url}/#plant?at=machine:M12", locale=LOCALES[language])
    expect(page.locator(".machine .recent-track .doing").first).to_be_attached()
    expect(page.locator(".atv .recent-track .doing").first).to_be_attached()
    for width_px, height_px in ((1280, 800), (1280, 900)):
        page.set_viewport_size({"width": width_px, "height": height_px})
        for strip in (".machine .recent", ".atv .recent"):
            expect(page.locator(strip)).to_be_in_viewport(ratio=1)
        assert page.locator(".orders .card-body").evaluate(ROWS_CUT) == []
        expect(page.locator(".orders")).to_be_in_viewport(ratio=1)
        expect(page.locator(".finder input")).to_be_visible()
        assert page.locator(".map-head").evaluate(STANDS_OUT) <= 0
        assert page.locator(".map .chip span").evaluate_all(LEAST_APART) >= APART_PX
        screenshot(page, f"small-laptop-{language}-{height_px}")


@pytest.mark.parametrize("language", LOCALES)
def test_on_a_tablet_layers_are_one_line_too(
    busy: Any, open_page: Callable[..., Page], screenshot: Callable[..., Path], language: str
) -> None:
    page = open_page(busy.url, viewport={"width": 1024, "height": 768}, locale=LOCALES[language])
    # That of right of way is there once vehicles have told of it.
    expect(page.locator(".map .chip")).to_have_count(8)
    for width_px, height_px in TABLETS_PX:
        page.set_viewport_size({"width": width_px, "height": height_px})
        # The page is laid out anew for each width, and the stream goes on.
        page.wait_for_function(ONE_LINE)
        screenshot(page, f"tablet-{language}-{width_px}")


@pytest.mark.parametrize("language", LOCALES)
def test_on_a_small_laptop_the_field_find_stays_in_its_line_and_what_is_written_in_it_stays_in_sight(
    busy: Any, open_page: Callable[..., Page], language: str
) -> None:
    page = open_page(busy.url, viewport={"width": 1280, "height": 800}, locale=LOCALES[language])
    tail, field = page.locator(".map-tail"), page.locator(".finder input")
    legend = tail.locator(".pop-button")
    expect(page.locator(".factory .duty-row")).to_be_visible()
    for width_px in SMALL_LAPTOPS_PX:
        page.set_viewport_size({"width": width_px, "height": 800})
        assert edges(field) == edges(page.locator(".finder")), width_px
        assert edges(field)[1] < edges(page.locator(".map-head"))[1], width_px
        assert edges(legend)[1] <= edges(field)[0], width_px
        field.fill("ATV8")
        field.blur()
        # All of what lies below it, so that half a button is not left.
        assert edges(field) == edges(tail), width_px
        assert edges(field)[0] <= edges(legend)[0], width_px
        assert field.evaluate("field => field.scrollWidth <= field.clientWidth"), width_px
        assert page.locator(".finder > .icon").evaluate(SHOWN_OVER, field.element_handle()), width_px
        # Who comes to it with the keys sees what has the focus.
        page.keyboard.press("Shift+Tab")
        legend.focus()
        assert legend.evaluate(ON_TOP), width_px
        field.fill("")
        field.blur()


def edges(of: Locator) -> tuple[float, float]:
    """Where something begins and ends from left to right, in pixels."""
    box = of.bounding_box()
    assert box is not None
    return round(box["x"], 1), round(box["x"] + box["width"], 1)


@pytest.mark.parametrize("language", LOCALES)
def test_what_can_be_done_with_what_is_chosen_is_whole_however_much_is_said_of_it(
    busy: Any, open_page: Callable[..., Page], screenshot: Callable[..., Path], language: str
) -> None:
    page = open_page(f"{busy.url}/#plant?at=machine:M12", locale=LOCALES[language])
    expect(page.locator(".card.machine h2")).to_contain_text("M12")
    for width_px, height_px in (*SIZES_PX, (1181, 800)):
        page.set_viewport_size({"width": width_px, "height": height_px})
        for card, least, chosen in (("machine", 3, "machine:M12"), ("atv", 2, "atv:ATV2")):
            page.evaluate("at => { location.hash = `plant?at=${at}`; }", chosen)
            around = page.locator(f".card.{card}")
            expect(around.locator("h2")).to_contain_text(chosen.partition(":")[2])
            expect(around.locator(".chosen-acts > button").nth(least - 1)).to_be_visible()
            assert around.evaluate(HEAD_APART), (width_px, card)
            # The page scrolls on a tablet, and no card within it.
            assert around.evaluate(ACTS_NOT_WHOLE, width_px < 1181) == [], (width_px, card)
        screenshot(page, f"chosen-{language}-{width_px}")


@pytest.mark.parametrize("language", LOCALES)
def test_each_card_shows_three_of_its_rows(
    busy: Any, open_page: Callable[..., Page], screenshot: Callable[..., Path], language: str
) -> None:
    page = open_page(busy.url, locale=LOCALES[language])
    cards = [page.locator(f".card.{name}") for name in ("factory", "orders", "publish", "machine", "atv")]
    for width_px, height_px in SIZES_PX:
        page.set_viewport_size({"width": width_px, "height": height_px})
        expect(page.locator(".orders .order").nth(2)).to_be_attached()
        expect(page.locator(".publish .feasible li").first).to_be_attached()
        for card in cards:
            expect(card).to_be_visible()
            if width_px < 1181:
                # The page scrolls there; no card within it has to.
                card.evaluate("(card) => card.scrollIntoView()")
            assert card.evaluate(ROWS_IN_SIGHT) >= 3, (width_px, card.get_attribute("class"))
        screenshot(page, f"cards-{language}-{width_px}")


def test_on_a_wall_text_is_larger_and_a_sheet_opens_beside_its_button(
    busy: Any, open_page: Callable[..., Page], screenshot: Callable[..., Path]
) -> None:
    page = open_page(busy.url, viewport={"width": 2560, "height": 1300})
    button = page.locator(".factory .pop-button").first
    expect(page.locator(".orders .order").first).to_be_visible()
    on_wall = page.locator(".orders .order-status").first.bounding_box()
    button.click()
    sheet = page.locator(".pop-sheet:popover-open")
    expect(sheet).to_be_visible()
    around, inside = button.bounding_box(), sheet.bounding_box()
    assert around is not None
    assert inside is not None
    assert 0 <= inside["y"] - around["y"] - around["height"] < 10
    assert inside["x"] <= around["x"] + around["width"] / 2 <= inside["x"] + inside["width"]
    screenshot(page, "cards-wall")
    page.keyboard.press("Escape")
    page.set_viewport_size({"width": 1440, "height": 1300})
    on_desk = page.locator(".orders .order-status").first.bounding_box()
    assert on_wall is not None
    assert on_desk is not None
    assert on_wall["height"] > 1.2 * on_desk["height"]
