"""Lists over all history in a real browser: found by words, sorted, turned over, linked to, and changed many at once."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from complaints import Complaints
from looks import LOCALES, THEMES, WIDTHS_PX, in_every_look
from playwright.sync_api import Page, Route, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture(scope="module")
def factory(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """A factory with 122 orders that nobody has published, and one that is made; from two imports and one order alone."""
    dray = start_dray("--speed", "20", "--no-demand", stepped=True)
    dray.advance(5.0)
    product = dray.ask("/api/products")["items"][0]["id"]
    for start in (0, 60):
        head = "customer,reference,product,quantity,release\n"
        rows = [f"Customer {n % 7},PO-{n:03},{product},2,false" for n in range(start, start + 60)]
        rows += [f"Hall E,OWN-{1 + start // 60},{product},2,false"]
        dray.ask("/api/orders/import", {"csv": head + "\n".join(rows), "dry_run": False})
    item = {"product": product, "quantity": 2}
    dray.ask("/api/orders", {"customer": "Hall D", "reference": "X-D5-9", "items": [item]})
    # It is shared out among machines.
    dray.advance(20.0)
    yield dray
    assert dray.stop() == 0, dray.output()


def test_an_order_is_found_behind_a_hundred_others_and_the_address_says_how(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{factory.url}/#orders")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(50)
    page.get_by_role("searchbox", name="Find in all").fill("d5 hall")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("X-D5-9")
    assert page.url.endswith("#orders?q=d5+hall")
    screenshot(page, "orders-found")

    again = open_page(page.url)
    expect(again.locator("tbody tr")).to_have_count(1)
    expect(again.get_by_role("searchbox", name="Find in all")).to_have_value("d5 hall")


def test_a_link_to_a_page_that_there_is_not_says_so_instead_of_the_list_before_it(
    factory: Any, open_page: OpenPage, complaints: Complaints
) -> None:
    page = open_page(f"{factory.url}/#orders?status=stored")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(50)
    page.goto(f"{factory.url}/#orders?after=nonsense")
    expect(page.locator("main")).to_contain_text("cursor: it is not from this list")
    expect(rows.filter(has_text="PO-")).to_have_count(0)
    page.get_by_role("navigation", name="Pages").get_by_role("button", name="Back").click()
    expect(rows).to_have_count(50)
    # The browser tells of each refusal by itself.
    page.goto("about:blank")
    assert all("status of 422" in each for each in complaints)
    complaints.clear()


def test_pages_and_sorting_are_steps_that_the_browser_goes_back(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{factory.url}/#orders?status=stored&q=PO-")
    first = page.locator("tbody tr").first
    page.get_by_role("button", name="Reference", exact=True).click()
    expect(first).to_contain_text("PO-000")
    expect(page.get_by_role("columnheader", name="Reference")).to_have_attribute("aria-sort", "ascending")
    page.get_by_role("button", name="More", exact=True).click()
    expect(first).to_contain_text("PO-050")
    page.get_by_role("button", name="More", exact=True).click()
    expect(first).to_contain_text("PO-100")
    expect(page.get_by_role("button", name="More", exact=True)).to_be_disabled()
    page.get_by_role("navigation", name="Pages").get_by_role("button", name="Back").click()
    expect(first).to_contain_text("PO-050")
    page.go_back()
    expect(first).to_contain_text("PO-100")
    page.go_back()
    page.go_back()
    expect(first).to_contain_text("PO-000")
    page.get_by_role("button", name="Reference", exact=True).click()
    expect(first).to_contain_text("PO-119")
    with page.expect_download() as download:
        page.get_by_role("link", name="CSV").click()
    lines = download.value.path().read_text().splitlines()
    assert len(lines) == 1 + 120
    assert "PO-119" in lines[1]
    screenshot(page, "orders-sorted")


def test_many_orders_are_cancelled_at_once_and_each_is_in_the_audit_log(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{factory.url}/#orders?status=stored&sort=reference&q=PO-01")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(10)
    for name in ("PO-011", "PO-012", "PO-013"):
        page.get_by_role("checkbox", name=f"Tick order {name}").check()
    bar = page.get_by_role("region", name="What to do with the ticked orders")
    expect(bar).to_contain_text("3 orders ticked")
    expect(bar.get_by_role("button", name="Take 0 back")).to_be_disabled()
    screenshot(page, "orders-ticked")
    bar.get_by_role("button", name="Cancel 3").click()
    expect(bar).to_contain_text("Cancel 3 orders? They will not be made.")
    expect(bar.get_by_role("button", name="Keep them")).to_be_focused()
    screenshot(page, "orders-cancel-many")
    bar.get_by_role("button", name="Cancel 3 orders").click()
    expect(rows).to_have_count(7)
    expect(bar).to_have_count(0)
    cancelled = factory.ask("/api/orders?status=cancelled&q=PO-01")["items"]
    assert sorted(order["reference"] for order in cancelled) == ["PO-011", "PO-012", "PO-013"]
    told = factory.ask("/api/audit?action=order.cancel")["items"]
    assert {line["target"] for line in told} >= {order["id"] for order in cancelled}


def test_why_an_order_was_refused_is_told_also_when_its_row_is_gone(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{factory.url}/#orders?status=stored&q=OWN-&sort=reference")
    rows = page.locator("tbody tr").filter(has_text="OWN-")
    expect(rows).to_have_count(2)
    gone = next(each["id"] for each in factory.ask("/api/orders?q=OWN-1")["items"])

    def cancel_first(route: Route) -> None:
        """Somebody else is quicker."""
        if gone in route.request.url:
            factory.ask(f"/api/orders/{gone}/cancel", {})
        route.continue_()

    page.route("**/api/orders/*/release", cancel_first)
    for name in ("OWN-1", "OWN-2"):
        page.get_by_role("checkbox", name=f"Tick order {name}").check()
    bar = page.get_by_role("region", name="What to do with the ticked orders")
    bar.get_by_role("button", name="Publish 2").click()
    expect(rows).to_have_count(0)
    expect(bar.get_by_role("alert")).to_contain_text("Order OWN-1: ")
    expect(bar.get_by_role("button")).to_have_count(1)
    screenshot(page, "orders-refused")
    bar.get_by_role("button", name="Close").click()
    expect(bar).to_have_count(0)
    # The browser tells of each refusal by itself.
    page.goto("about:blank")
    assert all("status of 409" in each for each in complaints)
    complaints.clear()


def test_tasks_of_all_history_are_found_by_their_order(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{factory.url}/#tasks?q=X-D5-9")
    rows = page.locator("tbody tr")
    expect(rows.filter(has_text="X-D5-9").first).to_be_visible()
    page.get_by_role("combobox", name="Kind").select_option("production")
    expect(rows.first).to_contain_text("X-D5-9")
    assert "kind=production" in page.url
    with page.expect_download() as download:
        page.get_by_role("link", name="CSV").click()
    assert all(",production," in line for line in download.value.path().read_text().splitlines()[1:])
    screenshot(page, "tasks-found")
    rows.first.get_by_role("link", name="X-D5-9").click()
    expect(page.get_by_role("heading", name="X-D5-9")).to_be_visible()


def test_the_audit_log_is_asked_for_by_its_address(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{factory.url}/#audit?action=order.import&sort=oldest")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(2)
    expect(page.get_by_role("combobox", name="What")).to_have_value("order.import")
    expect(page.get_by_role("columnheader", name="At", exact=True)).to_have_attribute(
        "aria-sort", "ascending"
    )
    page.get_by_role("combobox", name="What").select_option("order.place")
    expect(rows).to_have_count(1)
    # The order by its customer's number, and the way to its page and back.
    order = rows.locator("a.link")
    expect(order).to_have_text("X-D5-9")
    for theme in THEMES:
        page.emulate_media(color_scheme=theme)
        screenshot(page, f"audit-order-{theme}")
    order.click()
    expect(page.get_by_role("heading", name="X-D5-9")).to_be_visible()
    page.go_back()
    rows.get_by_role("button", name="Only X-D5-9").click()
    expect(page).to_have_url(re.compile("target=O-"))
    expect(rows).to_have_count(1)
    page.go_back()
    # A time that is typed, digit by digit, is no step.
    page.get_by_label("From", exact=True).click(position={"x": 12, "y": 12})
    page.keyboard.type("010220200304AM")
    expect(page).to_have_url(re.compile("since=2020-01-02T03%3A04"))
    expect(rows).to_have_count(1)
    page.go_back()
    expect(rows).to_have_count(2)


PRINTING = """window.print = () => {
    window.printed = [document.querySelectorAll("tbody tr").length, document.querySelector(".paper-only").textContent];
};"""


def test_all_that_the_filter_finds_is_printed_and_not_the_page_on_the_screen(
    factory: Any, open_page: OpenPage
) -> None:
    page = open_page("about:blank", visits=factory.url)
    page.add_init_script(PRINTING)
    page.goto(f"{factory.url}/#orders?q=Customer")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(50)
    for ask in (page.get_by_role("button", name="Print").click, partial(page.keyboard.press, "Control+p")):
        page.evaluate("window.printed = null")
        ask()
        page.wait_for_function("() => window.printed !== null")
        expect(page.get_by_role("button", name="Print")).to_be_enabled()
        count, sentence = page.evaluate("window.printed")
        assert count == 120
        assert sentence.startswith("All 120 that the filter finds, printed")
        expect(rows).to_have_count(50)
    page.emulate_media(media="print")
    expect(page.get_by_role("button", name="Print")).to_be_hidden()
    expect(page.get_by_role("navigation")).to_have_count(0)
    expect(page.get_by_role("columnheader", name="Reference")).to_be_visible()
    expect(page.get_by_text("Only the page on the screen")).to_be_visible()
    page.emulate_media(media="screen")


@in_every_look
def test_the_lists_fit_every_width(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str
) -> None:
    page = open_page(f"{factory.url}/#orders", locale=LOCALES[language], color_scheme=theme)
    for view in ("orders", "tasks"):
        page.goto(f"{factory.url}/#{view}")
        expect(page.locator("tbody tr").first).to_be_visible()
        for width in WIDTHS_PX:
            page.set_viewport_size({"width": width, "height": 900})
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), (view, width)
            screenshot(page, f"list-{view}-{language}-{theme}-{width}")
