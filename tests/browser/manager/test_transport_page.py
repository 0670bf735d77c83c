"""The page of one transport in a real browser, called for by people or by a machine: from the call to the hand-over, every way there, and what it prints."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from accessibility import violations
from complaints import Complaints
from looks import LOCALES, WIDTHS_PX, in_every_look
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def factory(quiet: Any) -> str:
    return str(quiet.url)


def call(quiet: Any, **fields: Any) -> str:
    """Have a load brought; its id."""
    wanted = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 3}
    return str(quiet.ask("/api/transports", wanted | fields)["id"])


def state(quiet: Any, name: str) -> str:
    return str(quiet.ask(f"/api/transports/{name}")["status"])


def test_it_tells_a_transport_from_its_call_to_its_hand_over(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    name = call(quiet)
    page = open_page(f"{factory}/#transports")
    page.get_by_role("link", name=name).focus()
    page.keyboard.press("Enter")
    heading = page.get_by_role("heading", level=1)
    expect(heading).to_have_text("3 Shaft: S3 → M8")
    expect(page).to_have_url(re.compile(rf"#transports/{name}$"))
    moments = page.locator(".order-moments li")
    expect(moments.last).to_contain_text("has called for 3 Shaft to M8")
    figures = page.locator(".order-figures")
    expect(figures).not_to_contain_text("Picked up")
    quiet.advance_until(lambda: state(quiet, name) == "on_board")
    expect(page.locator(".lane-transport .lane-carry")).to_have_count(1)
    for step in ("Vehicle set off", "Picked up"):
        expect(figures.locator("div").filter(has_text=step)).to_contain_text(re.compile(r"\d\d:\d\d"))
    expect(page.locator(".lane-signs")).to_contain_text("now ")
    expect(page.get_by_role("button", name="Call off")).to_have_count(0)
    # The task on the plant leads back here.
    page.get_by_role("button", name="Show on the plant").click()
    page.locator(".story").get_by_role("link", name=name).click()
    expect(heading).to_have_text("3 Shaft: S3 → M8")
    quiet.advance_until(lambda: state(quiet, name) == "delivered", step_s=10.0)
    expect(page.locator(".order-head .tag").first).to_have_text("delivered")
    told = page.locator(".order-told")
    expect(told).to_contain_text(re.compile(r"ATV\d+ handed it over at M8 at "))
    expect(page.get_by_role("heading", name="Link to follow it")).to_be_visible()
    for kind in ("called", "won", "fetched", "hand-over", "delivered"):
        expect(moments.filter(has_text=kind).first).to_be_visible()
    assert violations(page) == []
    screenshot(page, "transport-page")

    # Its address leads here again, and what is chosen on it stands there too.
    page.locator(".lane-transport").click()
    expect(page).to_have_url(re.compile(rf"#transports/{name}\?transport={name}-1$"))
    page.reload()
    expect(page.locator(".lane-transport")).to_have_attribute("aria-pressed", "true")
    page.go_back()
    expect(page.locator(".lane-transport")).to_have_attribute("aria-pressed", "false")
    page.get_by_role("link", name="Plain transports").click()
    expect(heading).to_contain_text("Plain transports")
    page.go_back()
    expect(heading).to_have_text("3 Shaft: S3 → M8")


def test_one_that_waits_says_why_and_is_called_off_there(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    with quiet.going():
        quiet.ask("/api/atvs/ATV3/commands", {"command": "out-of-transport-page", "kind": "take_out"})
    name = call(quiet, quantity=2, vehicle="ATV3")
    quiet.advance(5.0)
    page = open_page(f"{factory}/#transports/{name}")
    waits = page.locator(".order-waits")
    expect(waits).to_contain_text("ATV3: it is out of service")
    screenshot(page, "transport-page-waits")
    page.get_by_role("button", name="Call off").click()
    expect(page.get_by_role("button", name="Keep it")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Keep it")).to_have_count(0)
    page.get_by_role("button", name="Call off").click()
    page.get_by_role("group").get_by_role("button", name="Call off").click()
    quiet.advance_until(lambda: state(quiet, name) == "cancelled")
    expect(page.locator(".order-head .tag").first).to_have_text("called off")
    expect(page.locator(".order-moments")).to_contain_text("Somebody has called it off")
    # The audit log names it, and leads here.
    page.goto(f"{factory}/#audit")
    page.get_by_role("link", name=name).first.click()
    expect(page.get_by_role("heading", level=1)).to_have_text("2 Shaft: S3 → M8")


def test_a_transport_that_there_is_not_says_so(
    factory: str, open_page: OpenPage, complaints: Complaints
) -> None:
    page = open_page(f"{factory}/#transports/T-1M9K3X2A4-K7QM")
    expect(page.get_by_role("main")).to_contain_text("could not be read")
    page.get_by_role("link", name="All plain transports").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Plain transports")
    # The browser tells of every 404 by itself, and of nothing else.
    assert all("status of 404" in each for each in complaints)
    complaints.clear()


def test_what_a_machine_has_brought_has_the_same_page(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    product = quiet.ask("/api/products")["items"][0]["id"]
    placed = {"customer": "Waterworks South", "items": [{"product": product, "quantity": 200}]}
    order = quiet.ask("/api/orders", placed)["id"]

    def brought() -> str:
        """A transport of material that has ended."""
        tasks = quiet.ask("/api/tasks/history?kind=transport&state=delivered")["items"]
        own = (task["id"] for task in tasks if task["order"] == "" and not task["id"].startswith("T-"))
        return str(next(own, ""))

    quiet.advance_until(lambda: brought() != "", step_s=10.0)
    name = brought()
    page = open_page(f"{factory}/#tasks?kind=transport&state=delivered&q={name}")
    page.locator("tbody tr").filter(has_text=name).get_by_role("link").focus()
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile(rf"#transports/{re.escape(name)}$"))
    machine = name.split(".")[0].rsplit("-", 1)[0]
    expect(page.get_by_role("heading", level=1)).to_contain_text(f" → {machine}")
    moments = page.locator(".order-moments li")
    expect(moments.last).to_contain_text(f"{machine} has called for ")
    for kind in ("called", "won", "fetched", "hand-over", "delivered"):
        expect(moments.filter(has_text=kind).first).to_be_visible()
    expect(page.locator(".order-told")).to_contain_text(
        re.compile(rf"ATV\d+ handed it over at {machine} at ")
    )
    expect(page.locator(".order-head .tag").first).to_have_text("delivered")
    assert violations(page) == []
    screenshot(page, "task-page")
    # The plant leads there, too, while it knows of it.
    page.get_by_role("button", name="Show on the plant").click()
    page.get_by_role("region", name=f"Auction {name}").get_by_role("link", name=name).click()
    expect(page.get_by_role("heading", level=1)).to_contain_text(f" → {machine}")
    page.get_by_role("link", name="Tasks", exact=True).last.click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Tasks")
    quiet.ask(f"/api/orders/{order}/cancel", {})


def test_it_prints_on_one_page_without_what_can_be_clicked(
    quiet: Any, factory: str, open_page: OpenPage, tmp_path: Path
) -> None:
    name = call(quiet)
    quiet.advance_until(lambda: state(quiet, name) == "on_board")
    page = open_page(f"{factory}/#transports/{name}", color_scheme="dark")
    expect(page.locator(".lane-transport")).to_be_visible()
    page.emulate_media(media="print", color_scheme="dark")
    for what in (".top", ".order-deeds", ".order-moments .segments"):
        expect(page.locator(what)).to_be_hidden()
    background = page.evaluate("getComputedStyle(document.querySelector('.order-lanes')).backgroundColor")
    assert background in ("rgb(255, 255, 255)", "rgba(0, 0, 0, 0)")
    pdf = page.pdf(path=tmp_path / "transport.pdf", format="A4")
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) == 1


@in_every_look
def test_it_fits_every_width(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str
) -> None:
    name = call(quiet, priority="urgent")
    quiet.advance_until(lambda: state(quiet, name) == "on_board")
    page = open_page(f"{factory}/#transports/{name}", locale=LOCALES[language], color_scheme=theme)
    expect(page.locator(".lane-transport")).to_be_visible()
    for width in WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        assert page.evaluate("document.querySelector('.order-page').scrollWidth <= innerWidth"), width
        screenshot(page, f"transport-page-{language}-{theme}-{width}")
