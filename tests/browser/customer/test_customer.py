"""The customer's page in a real browser: live, in every language, by keyboard, on paper, and without a script."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from variants import later, variants

OpenPage = Callable[..., Page]
Screenshot = Callable[[Page, str], Path]

CUT = """() => {
    const real = window.fetch;
    window.cut = true;
    window.fetch = (...all) => window.cut ? Promise.reject(new TypeError("cut")) : real(...all);
}"""
"""From now on no question arrives, as long as `cut` is true."""

PHONE = {"width": 360, "height": 740}


@pytest.fixture
def factory(quiet: Any) -> Any:
    """A factory in which nobody orders but the test."""
    return quiet


def order(factory: Any, quantity: int, **fields: Any) -> str:
    """Place an order; the address of its customer's page."""
    body = {"customer": "Hall 3", "items": [{"product": "gear-unit-g1", "quantity": quantity}], **fields}
    return str(factory.ask("/api/orders", body)["tracking_url"])


def stage(page: Page, name: str) -> Any:
    return page.get_by_role("listitem").filter(has_text=re.compile(f"^\\s*{name}"))


@pytest.mark.slow
def test_a_customer_follows_an_order_to_its_delivery_without_touching_the_page(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    asked: list[str] = []
    page = open_page("about:blank")
    page.on("request", lambda request: asked.append(request.url))
    page.goto(order(factory, 4, reference="PO-customer"))
    expect(page.get_by_role("heading", level=1)).to_have_text(re.compile("4 . Gear unit G1"))
    expect(page.get_by_text("Order PO-customer")).to_be_visible()
    found = "/api/orders?q=PO-customer"
    factory.advance_until(lambda: factory.ask(found)["items"][0]["status"] == "in_production")
    expect(stage(page, "In production")).to_have_attribute("aria-current", "step")
    screenshot(page, "customer-in-production")
    factory.advance_until(lambda: factory.ask(found)["items"][0]["status"] == "delivered")
    expect(page.locator("main")).to_have_attribute("data-ended", "")
    expect(stage(page, "Delivered").first).to_have_class("done")
    expect(page.locator("#said")).to_contain_text("Today")
    screenshot(page, "customer-delivered")
    assert {url.split("/")[2] for url in asked if url != "about:blank"} == {factory.url.split("/")[2]}


@pytest.mark.parametrize("theme", variants(["dark", "light"]))
@pytest.mark.parametrize(
    ("locale", "words"), [("en-GB", "As of"), *later(("de-DE", "Stand"), ("es-ES", "Actualizado"))]
)
def test_every_language_and_theme_fits_a_small_telephone(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, theme: str, locale: str, words: str
) -> None:
    page = open_page(order(factory, 9000), who=None, viewport=PHONE, color_scheme=theme, locale=locale)
    expect(page.locator("#as-of")).to_contain_text(words)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    for link in page.get_by_role("navigation").get_by_role("link").all():
        box = link.bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) >= 44
    screenshot(page, f"customer-{locale[:2]}-{theme}")


@pytest.mark.slow
def test_a_language_is_chosen_by_keyboard_and_remembered(factory: Any, open_page: OpenPage) -> None:
    url = order(factory, 9000)
    page = open_page(url, who=None)
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Skip to the order")).to_be_focused()
    for _ in range(2):
        page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Deutsch")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_text("Voraussichtliche Lieferung")).to_be_visible()
    page.goto(url)
    expect(page.locator("html")).to_have_attribute("lang", "de")


def test_a_page_without_a_script_tells_everything_and_how_to_ask_again(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(order(factory, 9000), who=None, java_script_enabled=False)
    expect(page.get_by_role("heading", level=1)).to_have_text(re.compile("9,000 . Gear unit G1"))
    expect(page.get_by_role("list").nth(1).get_by_role("listitem")).to_have_count(5)
    expect(page.get_by_text("updates by itself")).to_be_hidden()
    page.get_by_role("link", name="Show the newest state").click()
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    screenshot(page, "customer-without-script")


def test_times_are_those_of_the_reader(factory: Any, open_page: OpenPage) -> None:
    page = open_page(order(factory, 9000), who=None, timezone_id="Asia/Tokyo")
    expect(page.locator("#zone")).to_have_text("Times are in Asia/Tokyo")
    expect(page.locator("main")).to_have_attribute("data-zone", "Asia/Tokyo")


def test_a_lost_connection_is_said_and_its_return_too(factory: Any, open_page: OpenPage) -> None:
    page = open_page("about:blank")
    page.clock.install()
    page.goto(order(factory, 9000))
    expect(page.locator("#offline")).to_be_hidden()
    # A connection that is cut for real makes Chromium complain, and complaints fail the test.
    page.evaluate(CUT)
    page.clock.run_for(40_000)
    expect(page.locator("#offline")).to_contain_text("No connection. Last known state:")
    expect(page.get_by_role("heading", level=1)).to_be_visible()
    # As the browser says when its own connection is back: the page does not wait for its next turn.
    page.evaluate("() => { window.cut = false; dispatchEvent(new Event('online')); }")
    expect(page.locator("#offline")).to_be_hidden()


@pytest.mark.slow
def test_paper_is_black_on_white_whatever_the_theme(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(order(factory, 9000), who=None, color_scheme="dark")
    page.emulate_media(media="print")
    body = "getComputedStyle(document.body)"
    assert page.evaluate(f"[{body}.color, {body}.backgroundColor]") == ["rgb(0, 0, 0)", "rgb(255, 255, 255)"]
    expect(page.get_by_role("navigation")).to_be_hidden()
    screenshot(page, "customer-print")
