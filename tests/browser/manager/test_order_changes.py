"""Orders in work in a real browser: changed by a form, and moved in the queue by hand and by a button."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from accessibility import violations
from complaints import Complaints
from playwright.sync_api import Locator, Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


def place(forms: Any, reference: str) -> str:
    """Place an order that takes hours, at a moment of its own; its id."""
    items = [{"product": "motor-e4", "quantity": 300}]
    placed = forms.ask("/api/orders", {"customer": "Acme", "reference": reference, "items": items})
    forms.advance(0.1)
    return str(placed["id"])


def references(rows: Locator) -> list[str]:
    return [row.get_by_role("link").first.inner_text() for row in rows.all()]


def test_an_order_in_work_is_changed_and_moved_and_who_comes_too_late_is_told_so(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{forms.url}/#orders")
    first, second, third = (place(forms, reference) for reference in ("FIRST", "SECOND", "THIRD"))

    # By hand, then by the button.
    rows = page.locator("tbody tr[draggable=true]")
    expect(rows).to_have_count(3)
    expect(rows.first).to_contain_text("FIRST")
    page.locator("tr", has_text="THIRD").drag_to(page.locator("tr", has_text="FIRST"))
    bar = page.get_by_role("region", name="How the order is moved in the queue")
    expect(bar).to_contain_text(
        "THIRD before FIRST? It would pass 2 for the same products, first FIRST, SECOND."
    )
    # Nothing is saved before somebody says so.
    assert references(rows) == ["FIRST", "SECOND", "THIRD"]
    assert violations(page) == []
    screenshot(page, "orders-moving")
    bar.get_by_role("button", name="Move", exact=True).click()
    expect(rows.first).to_contain_text("THIRD")
    assert references(rows) == ["THIRD", "FIRST", "SECOND"]
    expect(bar).to_have_count(0)
    # By the keyboard alone: further than one place, left as it is, and one place.
    sooner = page.get_by_role("button", name="Sooner: SECOND one place on")
    sooner.press("Enter")
    expect(bar.get_by_role("button", name="Move", exact=True)).to_be_focused()
    bar.get_by_role("button", name="One place further").press("Enter")
    expect(bar).to_contain_text("SECOND before THIRD?")
    page.keyboard.press("Escape")
    expect(bar).to_have_count(0)
    assert references(rows) == ["THIRD", "FIRST", "SECOND"]
    expect(sooner).to_be_focused()
    sooner.press("Enter")
    expect(bar).to_contain_text("SECOND before FIRST? It would pass one for the same products: FIRST.")
    expect(bar.get_by_role("button", name="Move", exact=True)).to_be_focused()
    page.keyboard.press("Enter")
    expect(rows.nth(1)).to_contain_text("SECOND")
    screenshot(page, "orders-moved")

    # By the form of its page, beside somebody else.
    page.goto(f"{forms.url}/#orders/{first}")
    form = page.locator(".order-change")
    save = form.get_by_role("button", name="Save changes")
    expect(save).to_be_disabled()
    form.get_by_label("Priority").select_option("urgent")
    form.get_by_label("Reference").fill("FIRST-B")
    expect(form).to_contain_text("not saved yet")
    screenshot(page, "order-changing")
    save.click()
    expect(page.get_by_role("heading", level=1)).to_have_text("FIRST-B")
    # Until the factory has answered.
    expect(form).to_contain_text("being changed")
    with forms.going():
        expect(form).to_contain_text("nothing changed yet")

    form.get_by_label("Reference").fill("FIRST-C")
    kept = page.request.get(f"{forms.url}/api/orders/{first}")
    other = page.request.patch(
        f"{forms.url}/api/orders/{first}",
        data={"reference": "FIRST-D"},
        headers={"If-Match": kept.headers["etag"]},
    )
    assert other.ok, other.text()
    save.click()
    expect(form.get_by_role("alert")).to_contain_text("somebody has changed it meanwhile")
    complaints.clear()
    form.get_by_role("button", name="Undo").click()
    expect(form.get_by_label("Reference")).to_have_value("FIRST-D")

    form.locator("input[inputmode=numeric]").fill("0")
    expect(form).to_contain_text("That is not possible")
    expect(save).to_be_disabled()
    assert page.request.get(f"{forms.url}/api/orders/{third}").json()["items"][0]["quantity"] == 300

    for order in (first, second, third):
        forms.ask(f"/api/orders/{order}/cancel", {})
