"""Production in a real browser: looked ahead for, defined, published, taken back, and published again."""

from __future__ import annotations

import re
from collections.abc import Callable
from math import sin
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[[Page, str], Path]


IN_WORK = re.compile("planned|in production")
"""A machine has taken it; whether one works at it yet depends on what else is ordered."""


@pytest.fixture
def factory(quiet: Any) -> str:
    return str(quiet.url)


def test_production_is_defined_published_taken_back_and_published_again(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory)
    page.get_by_label("Quantity").fill("400")
    page.get_by_label("Customer").fill("Hall 3")
    expect(page.locator(".feasible")).to_contain_text("can make it")
    expect(page.locator(".feasible")).to_contain_text(re.compile(r"Expected .+ to .+"))
    page.get_by_role("button", name="Details").click()
    needs = page.get_by_role("dialog", name="What it would need")
    expect(needs.get_by_role("row").filter(has_text="free").first).to_be_visible()
    screenshot(page, "production-needs")
    needs.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Define").click()
    expect(page.locator(".outcome-good")).to_contain_text("Defined as")

    page.get_by_role("link", name="Orders", exact=True).click()
    row = page.get_by_role("row").filter(has_text="Hall 3")
    expect(row).to_contain_text("defined")
    row.get_by_role("button", name="Publish").click()
    expect(row).to_contain_text("published")
    quiet.advance(10.0)
    expect(row).to_contain_text(IN_WORK)
    row.get_by_role("button", name="Cancel").dblclick()
    expect(row).to_contain_text("Cancel this order?")
    safe = row.get_by_role("button", name="Keep order")
    expect(safe).to_be_focused()
    expect(row.get_by_role("button", name="Cancel order")).to_be_visible()
    safe.click()
    expect(row).to_contain_text(IN_WORK)
    row.get_by_role("button", name="Take back").click()
    expect(row).to_contain_text("What has arrived stays delivered")
    screenshot(page, "production-take-back")
    row.get_by_role("button", name="Take the order back").click()
    expect(row).to_contain_text("being taken back")
    quiet.advance(10.0)
    expect(row).to_contain_text("taken back")
    expect(row.get_by_role("button", name="Publish")).to_be_visible()
    row.get_by_role("button", name="Publish").click()
    expect(row).to_contain_text("published")
    quiet.advance(10.0)
    expect(row).to_contain_text(IN_WORK)


def some_history(step_s: int, steps: int) -> dict[str, Any]:
    """An answer of the gateway: figures that go up and down, and one step of which nothing was seen."""
    since_s = 1_900_000_800 // step_s * step_s
    items = []
    for step in range(steps):
        wave = 0.5 + 0.4 * sin(step / 5)
        parts = (0.5 * wave, 0.1, 0.1, 0.02, 0.28, 0.5 - 0.5 * wave)
        names = ("moving", "waiting", "charging", "blocked", "silent", "idle")
        items.append(
            {f"{name}_frac": part for name, part in zip(names, parts, strict=True)}
            | dict.fromkeys(("on_time_frac", "atv_available_frac", "machine_available_frac"), 0.97)
            | {"at_s": since_s + step * step_s, "span_s": step_s, "starved_frac": 0.02, "empty_frac": wave}
            | {"transport_p50_s": 60 + 30 * wave, "transport_p95_s": 150.0, "transports": 4, "helps": 0}
            | {"transports_per_hour": 40 * wave, "orders_delivered": 1, "commands": step % 3}
        )
    del items[7]
    return {"since_at_s": since_s, "until_at_s": since_s + steps * step_s, "step_s": step_s, "items": items}


def some_pieces() -> dict[str, Any]:
    """What two machines have made, one of them with some bad pieces."""
    counts = {("M1", "gear-unit-g1"): (388, 12), ("M2", "pump-p3"): (100, 0)}
    lines = [
        {
            "machine": machine,
            "product": product,
            "good_quantity": good,
            "scrap_quantity": bad,
            "produced_quantity": good + bad,
            "quality_ratio": good / (good + bad),
        }
        for (machine, product), (good, bad) in counts.items()
    ]
    sums = {"good_quantity": 488, "scrap_quantity": 12, "produced_quantity": 500, "quality_ratio": 0.976}
    return {"since_at_s": 0.0, "until_at_s": 3600.0, **sums, "items": lines}


@pytest.mark.slow
def test_the_figures_are_charts_that_keys_can_read_with_tables_behind_them(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page("about:blank", visits=factory)

    def answer(route: Route) -> None:
        step_s = int(re.search(r"step=(\d+)", route.request.url).group(1))  # type: ignore[union-attr]
        route.fulfill(json=some_history(step_s, 60 if step_s == 60 else 160))

    page.route("**/api/kpis/history?*", answer)
    page.route("**/api/kpis/quality?*", lambda route: route.fulfill(json=some_pieces()))
    scripts: list[str] = []
    page.on("request", lambda request: scripts.append(request.url))
    page.goto(factory)
    expect(page.get_by_role("link", name="Figures")).to_be_visible()
    assert not any("KpiCharts" in url for url in scripts)
    page.get_by_role("link", name="Figures").click()
    expect(page.locator(".kpi-plot canvas")).to_have_count(7)
    assert any("KpiCharts" in url for url in scripts)
    screenshot(page, "figures")

    quality = page.locator(".kpi-quality")
    expect(quality).to_contain_text("ISO 22400-2")
    expect(quality.get_by_role("row").nth(1)).to_contain_text("Gear")
    expect(quality.get_by_role("row").nth(1)).to_contain_text("97.0")
    expect(quality.get_by_role("row").last).to_contain_text("All machines")
    quality.scroll_into_view_if_needed()
    screenshot(page, "figures-quality")

    card = page.locator(".kpi-interventions")
    expect(card.locator(".kpi-legend")).to_contain_text("commands 2")
    card.get_by_role("img").focus()
    for key, figure in (("Home", "commands 0"), ("ArrowRight", "commands 1"), ("End", "commands 2")):
        page.keyboard.press(key)
        expect(card.locator(".kpi-legend")).to_contain_text(figure)
    card.get_by_role("button", name="Table").click()
    expect(card.get_by_role("row")).to_have_count(1 + 59)

    page.get_by_role("button", name="7 d").click()
    expect(card.get_by_role("row")).to_have_count(1 + 159)
    page.emulate_media(color_scheme="dark")
    screenshot(page, "figures-dark")


@pytest.mark.slow
def test_a_file_of_orders_is_looked_through_and_then_placed(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{factory}/#orders")
    page.get_by_role("button", name="Import").click()
    dialog = page.get_by_role("dialog", name="Orders from a spreadsheet")
    choose = dialog.locator("input[type=file]")
    head = "customer,reference,product,quantity\n"

    def file_of(rows: str) -> Any:
        return {"name": "orders.csv", "mimeType": "text/csv", "buffer": (head + rows).encode()}

    choose.set_input_files(file_of("Hall 7,A,gear-unit-g1,5\nHall 8,B,nothing,5\n"))
    expect(dialog).to_contain_text("1 fault")
    expect(dialog.get_by_role("row").filter(has_text="does not make")).to_contain_text("product")
    screenshot(page, "orders-import")
    choose.set_input_files(file_of("Hall 7,A,gear-unit-g1,5\nHall 8,B,pump-p3,5\n"))
    expect(dialog).to_contain_text("2 orders, nothing wrong")
    dialog.get_by_role("button", name="Place them").click()
    expect(dialog).to_contain_text("2 orders placed")
    old = (head + "Hall 7,A,gear-unit-g1,5\nMüller,,pump-p3,5\n").encode("cp1252")
    choose.set_input_files({"name": "orders.csv", "mimeType": "text/csv", "buffer": old})
    expect(dialog).to_contain_text("2 orders, nothing wrong")
    expect(dialog).to_contain_text("Look at these first")
    expect(dialog.get_by_role("row").filter(has_text="Hall 7 has order")).to_contain_text("reference")
    expect(dialog.get_by_role("row").filter(has_text="read as windows-1252")).to_be_visible()
    screenshot(page, "orders-import-hints")
    dialog.get_by_role("button", name="Close").click()
    for customer in ("Hall 7", "Hall 8"):
        expect(page.get_by_role("row").filter(has_text=customer)).to_be_visible()
