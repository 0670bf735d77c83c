"""Plain transports in a real browser: called for by a form, followed with the reason why they wait, and called off."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from complaints import Complaints
from looks import LOCALES, WIDTHS_PX, in_every_look
from playwright.sync_api import Page, Route, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


def without_rows(route: Route) -> None:
    """The list, as long as nobody has called for anything."""
    answer = route.fetch()
    route.fulfill(response=answer, json=answer.json() | {"items": []})


def test_a_load_is_called_for_and_seen_and_one_that_waits_for_its_vehicle_tells_why_and_is_called_off(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{forms.url}/#tasks")
    # Other tests call for something in this factory, too.
    page.route("**/api/transports?*", without_rows)
    page.get_by_role("link", name="Plain transports").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Plain transports")
    expect(page.get_by_text("Nobody has called for anything yet.")).to_be_visible()
    page.unroute("**/api/transports?*", without_rows)
    page.reload()

    page.get_by_role("button", name="Call…").click()
    page.get_by_label("Material").select_option("shaft")
    priority = page.get_by_label("Priority")
    expect(priority).to_have_accessible_description(re.compile("low 60 min"))
    expect(page.locator("#call-ageing")).to_contain_text("lets others pass for 5 min at most")
    page.get_by_label("Pieces").fill("4000")
    page.get_by_label("To", exact=True).select_option("M8")
    page.get_by_label("Vehicle that carries").select_option("pallet")
    page.get_by_role("button", name="Call for it").click()
    expect(page.locator("#call-quantity-wrong")).to_contain_text("One load of Shaft is 40 at most")
    # A slip of the keyboard is not offered as so many loads.
    expect(page.get_by_text("That would be 100 loads. At most 50 can be called for at once.")).to_be_visible()
    screenshot(page, "transports-form")
    page.get_by_label("Pieces").fill("500")
    page.get_by_role("button", name="Call for it").click()
    expect(page.get_by_role("button", name="Call for several loads: 12 x 40 + 20")).to_be_enabled()
    # What is refused, the browser tells of by itself.
    assert all("status of 422" in each for each in complaints)
    complaints.clear()

    page.get_by_label("Pieces").fill("4")
    page.get_by_label("Priority").select_option("low")
    page.get_by_role("button", name="Call for it").click()
    expect(page.get_by_role("status").filter(has_text="Called: T-")).to_be_visible()
    page.get_by_role("button", name="Close").click()
    row = page.get_by_role("row", name="4 Shaft")
    expect(row).to_contain_text("to M8")
    expect(row).to_contain_text("only those that carry pallet")
    expect(row).to_contain_text("low")
    screenshot(page, "transports-list")

    page.get_by_label("State").select_option("cancelled")
    expect(row).to_have_count(0)
    page.get_by_label("State").select_option("")
    expect(row).to_be_visible()

    # Nobody else may carry it, and that one takes no work.
    with forms.going():
        forms.ask("/api/atvs/ATV3/commands", {"command": "out-1", "kind": "take_out"})
    page.get_by_role("button", name="Call…").click()
    page.get_by_label("Material").select_option("shaft")
    page.get_by_label("Pieces").fill("7")
    page.get_by_label("From", exact=True).select_option("M8")
    # The form keeps where the last load was called to.
    expect(page.get_by_label("To", exact=True)).to_have_value("M8")
    page.get_by_label("To", exact=True).select_option("")
    page.get_by_label("Vehicle", exact=True).select_option("ATV3")
    page.get_by_role("button", name="Call for it").click()
    expect(page.get_by_role("status").filter(has_text="Called: T-")).to_be_visible()
    page.get_by_role("button", name="Close").click()
    waiting = page.get_by_role("row", name="7 Shaft")
    expect(waiting).to_contain_text("ATV3: it is out of service")
    waiting.get_by_role("button", name="Call off").click()
    waiting.get_by_role("button", name="Keep it").click()
    waiting.get_by_role("button", name="Call off").click()
    waiting.get_by_role("group").get_by_role("button", name="Call off").click()
    # Until the factory has answered.
    expect(waiting).to_contain_text("being called off")
    with forms.going():
        expect(waiting).not_to_contain_text("being called off")
    expect(waiting).to_contain_text("called off")
    screenshot(page, "transports-called-off")


@in_every_look
def test_it_fits_every_width(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str
) -> None:
    page = open_page(f"{forms.url}/#transports", locale=LOCALES[language], color_scheme=theme)
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    page.locator("[popovertarget=call-form]").first.click()
    for width in WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        screenshot(page, f"transports-{language}-{theme}-{width}")
