"""What somebody writes in a form while it is being sent stays when the answer comes; what was sent makes room."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from complaints import Complaints
from manager_kit import choose, held
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


def test_a_reference_of_the_next_order_is_written_while_the_first_is_sent(
    forms: Any, open_page: OpenPage
) -> None:
    page = open_page(forms.url)
    form = page.locator(".publish")
    form.get_by_label("Product").select_option("pump-p3")
    form.get_by_label("Customer").fill("Hall 3")
    reference, define = form.get_by_label("Reference"), form.get_by_role("button", name="Define")
    for following, after in (("NEXT", "NEXT"), (None, "")):
        reference.fill("FIRST")
        with held(page, "**/api/orders") as let_go:
            define.click()
            expect(define).to_be_disabled()
            if following is not None:
                reference.fill(following)
            order = let_go()
        expect(page.locator(".outcome-good")).to_contain_text(order["id"])
        assert order["reference"] == "FIRST"
        expect(reference).to_have_value(after)
        expect(form.get_by_label("Customer")).to_have_value("Hall 3")
        forms.ask(f"/api/orders/{order['id']}/cancel", {})
        form.get_by_label("Customer").fill("Hall 4")
        form.get_by_label("Customer").fill("Hall 3")


def test_the_pieces_of_the_next_load_are_written_while_the_first_is_called(
    forms: Any, open_page: OpenPage
) -> None:
    page = open_page(f"{forms.url}/#transports")
    page.get_by_role("button", name="Call…").click()
    pieces, material = page.get_by_label("Pieces"), page.get_by_label("Material")
    material.select_option("shaft")
    pieces.fill("3")
    page.get_by_label("To", exact=True).select_option("M8")
    call = page.get_by_role("button", name="Call for it")
    with held(page, "**/api/transports") as let_go:
        call.click()
        expect(call).to_be_disabled()
        pieces.fill("2")
        called = let_go()
    expect(page.get_by_role("status").filter(has_text=called["id"])).to_be_visible()
    assert called["quantity"] == 3
    expect(pieces).to_have_value("2")
    expect(material).to_have_value("")
    expect(page.get_by_label("To", exact=True)).to_have_value("M8")
    forms.ask(f"/api/transports/{called['id']}/cancel", {})


def test_another_reason_is_written_while_a_vehicle_is_taken_out(forms: Any, open_page: OpenPage) -> None:
    page = open_page(forms.url)
    choose(page, "ATV5")
    card, sheet = page.locator(".card.atv"), page.locator(".pop-sheet:popover-open")
    card.get_by_role("button", name="Command…").click()
    sheet.get_by_label("Reason").fill("brakes")
    with held(page, "**/api/atvs/ATV5/commands") as let_go:
        sheet.get_by_role("button", name="Out of service").click()
        expect(sheet.get_by_role("status")).to_have_text("Sent; it has not answered yet.")
        sheet.get_by_label("Reason").fill("wheel")
        with forms.going():
            let_go()
            expect(card).to_contain_text("out of service")
    expect(sheet.get_by_role("status")).to_contain_text("ATV5 confirms")
    expect(sheet.get_by_label("Reason")).to_have_value("wheel")
    with forms.going():
        sheet.get_by_role("button", name="Put to work again").click()
        expect(card).not_to_contain_text("out of service")


def test_a_sheet_stays_with_what_is_written_while_a_lane_is_closed(forms: Any, open_page: OpenPage) -> None:
    page = open_page(forms.url)
    page.get_by_role("button", name="Close lanes…").click()
    sheet = page.locator(".pop-sheet:popover-open")
    sheet.get_by_label("How").select_option("slow")
    reason, act = sheet.get_by_label("Reason"), sheet.locator("button[type=submit]")
    closed = page.locator(".card.closures").get_by_role("listitem")
    expect(act).to_have_text("Slow lanes down")
    reason.fill("oil")
    with held(page, "**/api/closures") as let_go:
        act.click()
        expect(act).to_be_disabled()
        reason.fill("ice")
        let_go()
    expect(closed).to_contain_text("oil")
    expect(reason).to_have_value("ice")
    page.keyboard.press("Escape")
    expect(sheet).to_have_count(0)
    closed.get_by_role("button").click()
    expect(closed).to_have_count(0)


def test_what_is_refused_after_the_form_was_opened_for_another_thing_is_told_by_its_name_and_restored(
    forms: Any, open_page: OpenPage, complaints: Complaints, screenshot: Screenshot
) -> None:
    page = open_page(f"{forms.url}/#recurring")
    add, name = page.get_by_role("button", name="Add…"), page.get_by_label("Name", exact=True)
    add.click()
    name.fill("Early")
    page.get_by_label("Pieces each time").fill("0")
    with held(page, "**/api/schedules") as let_go:
        page.get_by_role("button", name="Keep", exact=True).click()
        page.get_by_role("button", name="Close").click()
        add.click()
        name.fill("Late")
        let_go()
    wrong = page.locator("#recurring-quantity-wrong")
    refused = page.get_by_role("alert").filter(has_text="Not done for Early")
    expect(refused).to_have_count(1)
    expect(wrong).to_be_empty()
    expect(name).to_have_value("Late")
    page.get_by_role("button", name="Close").click()
    screenshot(page, "recurring-refused-since")
    refused.get_by_role("button", name="Open it again").click()
    expect(name).to_have_value("Early")
    expect(page.get_by_label("Pieces each time")).to_have_value("0")
    expect(wrong).not_to_be_empty()
    expect(refused).to_have_count(0)
    # What is refused, the browser tells of by itself.
    assert all("status of 422" in each for each in complaints)
    complaints.clear()
