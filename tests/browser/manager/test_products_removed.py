"""Products that people have defined are removed in a real browser: after a question, several at once, and none that an order needs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from complaints import Complaints
from playwright.sync_api import Page, expect
from tablet_kit import Cable, be_cut_off, can_be_cut_off

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

FIELDS = {"lot": 4, "ability": "tote", "bill": {"shaft": 1}, "machines": {"M1": 30.0}}


def test_products_are_removed_after_a_question_and_one_that_an_order_needs_stays(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{forms.url}/#products")
    for number in (1, 2):
        defined = page.request.put(
            f"{forms.url}/api/products/odd-{number}",
            data=FIELDS | {"name": f"Odd {number}"},
            headers={"If-None-Match": "*"},
        )
        assert defined.ok, defined.text()
    items = [{"product": "odd-2", "quantity": 1}]
    order = forms.ask("/api/orders", {"customer": "Acme", "items": items, "release": False})
    page.reload()

    # What stands in the plant file cannot be ticked.
    first = page.get_by_role("row", name="Gear unit G1")
    expect(first).to_contain_text("plant file")
    expect(first.get_by_role("checkbox")).to_have_count(0)
    for number in (1, 2):
        page.get_by_label(f"Tick Odd {number}", exact=True).check()
    bar = page.get_by_label("What to do with the ticked products")
    bar.get_by_role("button", name="Remove 2 products…").click()
    expect(bar).to_contain_text("Orders that have ended keep their names")
    screenshot(page, "products-remove-asked")
    bar.get_by_role("button", name="Keep").click()
    expect(page.get_by_role("row", name="Odd 1")).to_be_visible()

    bar.get_by_role("button", name="Remove 2 products…").click()
    bar.get_by_role("button", name="Remove 2 products", exact=True).click()
    expect(bar.get_by_role("status")).to_contain_text("1 product is removed")
    expect(bar.get_by_role("alert")).to_contain_text("Odd 2 stays: Orders that have not ended need it")
    expect(bar.get_by_role("alert")).to_contain_text(order["id"])
    expect(page.get_by_role("row", name="Odd 1")).to_have_count(0)
    screenshot(page, "products-remove-one-stays")

    forms.ask(f"/api/orders/{order['id']}/cancel", {})
    bar.get_by_role("button", name="Remove 1 product…").click()
    expect(bar).to_contain_text("Remove Odd 2?")
    bar.get_by_role("button", name="Remove 1 product", exact=True).click()
    expect(page.get_by_role("row", name="Odd 2")).to_have_count(0)
    # The order that has ended keeps the name of its product.
    page.goto(f"{forms.url}/#orders")
    expect(page.get_by_role("row", name="Acme").filter(has_text="Odd 2").first).to_be_visible()
    assert page.request.get(f"{forms.url}/api/products/odd-2").status == 404


def test_nothing_is_removed_while_the_panel_is_cut_off_and_it_says_why(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page, cable = open_page("about:blank", visits=forms.url), Cable()
    can_be_cut_off(page, cable)
    page.goto(f"{forms.url}/#products")
    defined = page.request.put(
        f"{forms.url}/api/products/odd-3", data=FIELDS | {"name": "Odd 3"}, headers={"If-None-Match": "*"}
    )
    assert defined.ok, defined.text()
    page.reload()
    page.get_by_label("Tick Odd 3", exact=True).check()
    bar = page.get_by_label("What to do with the ticked products")
    expect(bar.get_by_role("button", name="Remove 1 product…")).to_be_enabled()
    be_cut_off(page, cable)
    expect(bar.get_by_role("button", name="Remove 1 product…")).to_be_disabled()
    expect(bar).to_contain_text("nothing can be removed now")
    screenshot(page, "products-remove-cut-off")
    cable.plug_in()
    expect(page.locator(".banner")).to_have_count(0)
    # Whether it asked for something meanwhile is nobody's concern.
    complaints[:] = [each for each in complaints if "ERR_INTERNET_DISCONNECTED" not in each]
    assert page.request.delete(f"{forms.url}/api/products/odd-3").ok
