"""A transport is called for from the plant with the keyboard alone, in several loads, not at once, and its page is shown to others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from accessibility import violations
from complaints import Complaints
from manager_kit import choose
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


def test_from_a_machine_on_the_plant_to_the_page_of_whoever_has_the_link(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{forms.url}/#plant")
    choose(page, "M8")
    page.locator(".card.machine").get_by_role("button", name="Bring here…").focus()
    page.keyboard.press("Enter")
    item = page.get_by_label("Material")
    expect(item).to_be_focused()
    expect(page.get_by_label("To", exact=True)).to_have_value("M8")
    item.select_option("shaft")
    page.get_by_label("Pieces").fill("45")
    page.get_by_label("Not before").fill("2099-01-01T06:00")
    page.keyboard.press("Enter")
    split = page.get_by_role("button", name="Call for several loads: 1 x 40 + 5")
    expect(split).to_be_visible()
    assert violations(page) == []
    screenshot(page, "call-from-plant")
    # What is refused, the browser tells of by itself.
    assert all("status of 422" in each for each in complaints)
    complaints.clear()
    split.click()
    called = page.get_by_role("status").filter(has_text="Called: T-").get_by_role("link")
    expect(called).to_be_visible()
    name = called.inner_text()
    page.goto(f"{forms.url}/#transports/{name}")
    expect(page.get_by_role("heading", level=1)).to_contain_text("5 Shaft: ")
    expect(page.locator(".order-side")).to_contain_text("begins ")
    page.get_by_role("button", name="Make a link").click()
    address = page.get_by_role("link", name="What they see").get_attribute("href")
    expect(page.locator(".order-links")).to_contain_text("1 valid")
    screenshot(page, "transport-links")

    theirs = open_page(str(address))
    expect(theirs.get_by_role("main")).to_contain_text("to M8")
    expect(theirs.get_by_role("main")).to_contain_text("Not started yet")
    assert violations(theirs) == []
    screenshot(theirs, "transport-for-others")
    page.get_by_role("button", name="Take all back").click()
    page.get_by_role("button", name="Take links back").click()
    expect(page.locator(".order-links")).to_contain_text("0 valid")
    page.get_by_role("button", name="Call off").click()
    page.get_by_role("group").get_by_role("button", name="Call off").click()
    expect(page.locator(".order-head .tag").first).to_have_text("called off")
