"""Products that something needs, in a real browser: what keeps one is named as people call it, with the way there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from complaints import Complaints
from looks import LOCALES, in_every_look
from playwright.sync_api import Page, Route, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

FIELDS = {"lot": 4, "ability": "tote", "bill": {"shaft": 1}, "machines": {"M1": 30.0}}


NEVER_AGAIN = """(() => {
    const later = window.setTimeout.bind(window);
    window.setTimeout = (call, ms, ...more) => (ms >= 10_000 ? 0 : later(call, ms, ...more));
})()"""
"""No view asks again because time has passed: what it shows anew it was told of."""


def define(page: Page, url: str, product: str, name: str) -> None:
    answer = page.request.put(
        f"{url}/api/products/{product}", data=FIELDS | {"name": name}, headers={"If-None-Match": "*"}
    )
    assert answer.ok, answer.text()


@in_every_look
def test_orders_that_keep_a_product_are_named_as_people_call_them_with_the_way_to_each(
    forms: Any,
    open_page: OpenPage,
    screenshot: Screenshot,
    complaints: Complaints,
    language: str,
    theme: str,
) -> None:
    product = f"kept-{language}-{theme}"
    page = open_page("about:blank", visits=forms.url, locale=LOCALES[language], color_scheme=theme)
    define(page, forms.url, product, f"Kept {language} {theme}")
    items = [{"product": product, "quantity": 1}]
    named = forms.ask(
        "/api/orders",
        {"customer": "Nordwerk", "reference": f"PO {language}", "items": items, "release": False},
    )
    plain = forms.ask("/api/orders", {"customer": "Acme", "items": items, "release": False})
    page.goto(f"{forms.url}/#products")
    page.get_by_role("row", name=f"Kept {language} {theme}").get_by_role("checkbox").check()
    bar = page.locator(".bulk-bar").first
    bar.locator("button").first.click()
    bar.locator(".sure button").last.click()
    told = bar.get_by_role("alert")
    expect(told).to_contain_text(f"PO {language} · Nordwerk")
    expect(told).to_contain_text(f"{plain['id']} · Acme")
    expect(told).not_to_contain_text(named["id"])
    for width, height in ((1440, 900), (1024, 768), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        screenshot(page, f"products-needed-{language}-{theme}-{width}")
    # The way opens beside the page: what was said stays.
    with page.context.expect_page() as opened:
        page.locator(".removal").get_by_text(f"PO {language} · Nordwerk", exact=True).click()
    expect(opened.value.locator("#order-title")).to_have_text(f"PO {language}")
    opened.value.close()
    expect(told).to_be_visible()

    for order in (named, plain):
        forms.ask(f"/api/orders/{order['id']}/cancel", {})
    complaints.clear()
    assert page.request.delete(f"{forms.url}/api/products/{product}").ok


def test_a_transport_that_keeps_a_product_is_led_to(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page("about:blank", visits=forms.url)
    define(page, forms.url, "brought-part", "Brought part")
    transport = forms.ask("/api/transports", {"from": "S3", "to": "M8", "item": "shaft", "quantity": 4})

    def needed(route: Route) -> None:
        # No plain transport brings a product that people have defined, as long as the plant file stays the same.
        reason = {
            "field": "product",
            "reason": "",
            "code": "needed_by_transport",
            "values": {"count": "1", "names": transport["id"]},
        }
        told = {"id": "brought-part", "result": "needed", "reasons": [reason]}
        route.fulfill(json={"products": [told]})

    page.route("**/api/products/remove", needed)
    page.goto(f"{forms.url}/#products")
    page.get_by_role("row", name="Brought part").get_by_role("checkbox").check()
    bar = page.locator(".bulk-bar").first
    bar.locator("button").first.click()
    bar.locator(".sure button").last.click()
    expect(bar.get_by_role("alert")).to_contain_text("4 Shaft → ")
    link = page.locator(f'.removal a[href="#transports/{transport["id"]}"]')
    expect(link).to_contain_text("4 Shaft → ")
    screenshot(page, "products-needed-by-transport")
    with page.context.expect_page() as opened:
        link.click()
    expect(opened.value.get_by_text(transport["id"]).first).to_be_visible()
    opened.value.close()

    forms.ask(f"/api/transports/{transport['id']}/cancel", {})
    complaints.clear()
    assert page.request.delete(f"{forms.url}/api/products/brought-part").ok


def test_a_removed_product_vanishes_from_open_panels(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{forms.url}/#plant")
    choices = page.locator(".publish select").first
    expect(choices.locator("option", has_text="Gear unit G1")).to_have_count(1)
    # Somebody else defines it, and nobody reloads anything.
    define(page, forms.url, "short-lived", "Short-lived part")
    forms.advance(2.0)
    choice = choices.locator("option", has_text="Short-lived part")
    expect(choice).to_have_count(1)
    choices.select_option("short-lived")
    lists = open_page("about:blank", visits=forms.url)
    lists.add_init_script(NEVER_AGAIN)
    lists.goto(f"{forms.url}/#products")
    expect(lists.get_by_role("row", name="Short-lived part")).to_be_visible()

    assert page.request.delete(f"{forms.url}/api/products/short-lived").ok
    forms.advance(2.0)
    expect(lists.get_by_role("row", name="Short-lived part")).to_have_count(0)
    expect(choice).to_have_count(0)
    # What was chosen is gone, and nothing else takes its place by itself.
    expect(choices).to_have_value("")
    page.locator(".publish").get_by_role("button", name="Publish").click()
    expect(page.locator("#publish-product-wrong, .publish .complaint").first).to_contain_text(
        "Choose a product"
    )
    screenshot(page, "publish-product-removed")
    choices.select_option(label="Gear unit G1")
    expect(choices.locator("option[value='']")).to_have_count(0)
