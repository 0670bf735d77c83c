"""Products in a real browser: defined, refused at their fields, changed beside somebody else, and ordered at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from complaints import Complaints
from looks import LOCALES, WIDTHS_PX, in_every_look
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


def test_a_product_is_defined_and_ordered_and_a_change_that_comes_too_late_is_refused(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    page = open_page(f"{forms.url}/#products")
    page.get_by_role("button", name="Define…").click()
    form = page.locator(".product-form")
    form.get_by_label("Id: letters").fill("pump-p9")
    form.get_by_label("Name", exact=True).fill("Pump P9")
    form.get_by_label("Pieces in one container").fill("4")
    form.get_by_label("Material, row 1").select_option("shaft")
    form.get_by_label("Pieces, row 1").fill("2")
    form.get_by_role("button", name="Define product").click()
    # Nobody would make it.
    expect(form.get_by_text("no machine makes it")).to_be_visible()
    screenshot(page, "product-refused")
    complaints.clear()

    form.get_by_label("Machine, row 1").select_option("M1")
    form.get_by_label("Seconds each, row 1").fill("30")
    form.get_by_role("button", name="Define product").click()
    expect(form.get_by_role("status")).to_contain_text("Pump P9 is defined, revision 1")
    page.get_by_role("button", name="Close").click()
    row = page.get_by_role("row", name="Pump P9")
    expect(row).to_contain_text("2 Shaft")
    expect(row).to_contain_text("M1")
    screenshot(page, "product-defined")

    items = [{"product": "pump-p9", "quantity": 4}]
    ordered = forms.ask("/api/orders", {"customer": "Acme", "items": items})
    assert ordered["items"][0]["product"] == "pump-p9"
    forms.ask(f"/api/orders/{ordered['id']}/cancel", {})

    # Somebody else is faster.
    row.get_by_role("button", name="Pump P9").click()
    form.get_by_label("Pieces, row 1").fill("3")
    kept = page.request.get(f"{forms.url}/api/products/pump-p9")
    told = kept.json()
    body = {key: told[key] for key in ("name", "lot", "ability", "bill", "machines", "documents")}
    other = page.request.put(
        f"{forms.url}/api/products/pump-p9",
        data=body | {"name": "Pump P9 long"},
        headers={"If-Match": kept.headers["etag"]},
    )
    assert other.ok, other.text()
    form.get_by_role("button", name="Define product").click()
    expect(form.get_by_role("status")).to_contain_text("somebody has changed it meanwhile")
    screenshot(page, "product-too-late")
    complaints.clear()
    page.get_by_role("button", name="Close").click()
    changed = page.get_by_role("row", name="Pump P9 long")
    expect(changed).to_contain_text("2 Shaft")
    page.get_by_role("button", name="Define…").click()
    form.get_by_label("Id: letters").fill("pump-p9")
    form.get_by_label("Name", exact=True).fill("Another pump")
    form.get_by_label("Pieces in one container").fill("4")
    form.get_by_label("Material, row 1").select_option("shaft")
    form.get_by_label("Pieces, row 1").fill("1")
    form.get_by_label("Machine, row 1").select_option("M1")
    form.get_by_label("Seconds each, row 1").fill("30")
    form.get_by_role("button", name="Define product").click()
    expect(form.locator("#product-id-wrong")).to_contain_text("there is one with this id already")
    complaints.clear()


@in_every_look
def test_the_form_fits_every_width(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str
) -> None:
    page = open_page(f"{forms.url}/#products", locale=LOCALES[language], color_scheme=theme)
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    page.locator("[popovertarget=product-form]").first.click()
    for width in WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
        screenshot(page, f"product-form-{language}-{theme}-{width}")
