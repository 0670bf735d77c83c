"""Recurring work in a real browser: planned, seen before it is kept, paused, and removed after being asked twice."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from complaints import Complaints
from looks import LOCALES, WIDTHS_PX, in_every_look
from manager_kit import as_manager, held
from open_house import open_house
from playwright.sync_api import Page, expect

from dray.gateway.http.provided import provided
from dray.gateway.schedules.scheduler import Scheduler

# Their folder is on the path since `open_house` is.
from gateway_kit import House  # isort: skip
from recurring_kit import BRING, DRAFT, PATH, SIX_S  # isort: skip
from wall_clock import Wall  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def page(forms: Any, open_page: OpenPage) -> Page:
    """The view, by the link on the page of orders."""
    page = open_page(f"{forms.url}/#orders", timezone_id="Europe/Berlin")
    page.get_by_role("link", name="Recurring work").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Recurring work")
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    return page


def plan(page: Page, name: str, quantity: str) -> None:
    page.get_by_role("button", name="Add…").click()
    page.get_by_label("Name", exact=True).fill(name)
    page.get_by_label("Material").select_option("shaft")
    page.get_by_label("Pieces each time").fill(quantity)
    page.get_by_label("To", exact=True).select_option("M8")


def keep(page: Page, name: str, *, close: bool = True) -> None:
    """Send the form, which is taken, and close it."""
    page.get_by_role("button", name="Keep", exact=True).click()
    expect(page.get_by_text(f"{name} is kept.")).to_be_visible()
    if close:
        page.get_by_role("button", name="Close").click()


def remove(page: Page, name: str) -> None:
    page.get_by_role("button", name=f"Remove {name}").click()
    page.get_by_role("group", name=f"Remove {name}?").get_by_role("button", name="Remove").click()
    expect(page.get_by_text("Nothing recurs yet.")).to_be_visible()


def test_work_is_planned_seen_in_advance_paused_and_removed(
    page: Page, screenshot: Screenshot, complaints: Complaints
) -> None:
    plan(page, "Early", "0")
    page.get_by_role("checkbox", name="Sun").check()
    page.get_by_label("at", exact=True).fill("02:30")
    expect(page.get_by_label("Time zone")).to_have_value("Europe/Berlin")
    page.get_by_role("button", name="Show the next moments").click()
    runs = page.get_by_role("region", name="Next").get_by_role("listitem")
    expect(runs).to_have_count(10)
    screenshot(page, "recurring-form")

    page.get_by_role("button", name="Keep", exact=True).click()
    expect(page.locator("#recurring-quantity-wrong")).not_to_be_empty()
    page.get_by_label("Pieces each time").fill("4")
    keep(page, "Early")
    row = page.get_by_role("row", name="Early")
    expect(row).to_contain_text("Mon to Fri, Sun at 02:30")
    expect(row).not_to_contain_text("not on")
    screenshot(page, "recurring-list")

    row.get_by_role("button", name="Early", exact=True).click()
    expect(page.get_by_role("checkbox", name="Sun")).to_be_checked()
    expect(page.get_by_role("checkbox", name="Sat")).not_to_be_checked()
    page.get_by_label("Not on these days").fill("2098-12-26, 2098-12-25")
    page.get_by_label("What was missed in an absence").select_option("catch_up")
    keep(page, "Early", close=False)
    expect(row).to_contain_text("not on 25 Dec 2098, 26 Dec 2098")
    expect(row).to_contain_text("after an absence the last one missed is made up for")
    # What is wrong is gone to, be it asked for what comes, or kept.
    page.get_by_label("Not on these days").fill("Christmas")
    page.get_by_role("button", name="Show the next moments").click()
    expect(page.get_by_label("Not on these days")).to_be_focused()
    page.get_by_label("Not on these days").fill("2098-12-25")
    page.get_by_label("Or cron's five fields").fill("61 * * * *")
    page.get_by_role("button", name="Keep", exact=True).click()
    expect(page.locator("#recurring-cron-wrong")).to_contain_text("This is no calendar of cron")
    page.get_by_role("button", name="Close").click()
    # What is refused, the browser tells of by itself.
    assert all("status of 422" in each for each in complaints)
    complaints.clear()

    skip = row.get_by_role("button", name=re.compile("^Skip .* of Early$"))
    first = str(skip.get_attribute("aria-label")).removeprefix("Skip ").removesuffix(" of Early")
    skip.click()
    expect(row).to_contain_text(f"skipped: {first}")
    expect(row.get_by_role("button", name=f"Skip {first} of Early")).to_have_count(0)
    screenshot(page, "recurring-skipped")
    row.get_by_role("button", name=f"Do {first} of Early all the same").click()
    expect(row.get_by_role("button", name=f"Skip {first} of Early")).to_be_visible()
    expect(row).not_to_contain_text("skipped")

    page.get_by_role("button", name="Pause Early").click()
    expect(row).to_contain_text("paused")
    page.get_by_role("button", name="Go on with Early").click()
    expect(page.get_by_role("button", name="Pause Early")).to_be_visible()
    page.get_by_role("button", name="Remove Early").click()
    page.get_by_role("button", name="Keep it").click()
    expect(row).to_be_visible()
    remove(page, "Early")


def test_an_order_is_planned_line_by_line_and_becomes_a_transport(
    page: Page, screenshot: Screenshot, complaints: Complaints
) -> None:
    page.get_by_role("button", name="Add…").click()
    page.get_by_label("Name", exact=True).fill("Weekly")
    page.get_by_label("What recurs").select_option("order")
    expect(page.get_by_label("Material")).to_have_count(0)
    page.get_by_label("Customer").fill("Hall 3")
    page.get_by_label("Due after so many hours").fill("0.1")
    page.get_by_label("Product in line 1").select_option("pump-p3")
    page.get_by_label("Pieces in line 1").fill("20")
    page.get_by_role("button", name="Add a line").click()
    page.get_by_label("Product in line 2").select_option("gear-unit-g1")
    page.get_by_role("button", name="Keep", exact=True).click()
    expect(page.locator("[id='recurring-line.1-wrong']")).not_to_be_empty()
    expect(page.locator("#recurring-dueH-wrong")).not_to_be_empty()
    page.get_by_label("Pieces in line 2").fill("2")
    page.get_by_label("Due after so many hours").fill("1.5")
    screenshot(page, "recurring-order-form")
    keep(page, "Weekly")
    row = page.get_by_role("row", name="Weekly")
    expect(row).to_contain_text("order for Hall 3")
    expect(row).to_contain_text("20 Pump P3, 2 Gear unit G1")
    screenshot(page, "recurring-order-list")

    row.get_by_role("button", name="Weekly", exact=True).click()
    expect(page.get_by_label("Pieces in line 2")).to_have_value("2")
    expect(page.get_by_label("Due after so many hours")).to_have_value("1.5")
    page.get_by_label("What recurs").select_option("transport")
    page.get_by_label("Material").select_option("shaft")
    page.get_by_label("Pieces each time").fill("4")
    page.get_by_label("To", exact=True).select_option("M8")
    keep(page, "Weekly")
    expect(row).to_contain_text("nearest storage to M8")
    # What is refused, the browser tells of by itself.
    assert all("status of 422" in each for each in complaints)
    complaints.clear()

    remove(page, "Weekly")


def test_the_public_holidays_of_a_region_are_left_out_before_and_after_it_is_kept(
    page: Page, screenshot: Screenshot
) -> None:
    plan(page, "After Epiphany", "4")
    page.get_by_label("Or cron's five fields").fill("0 6 6,7 1 *")
    runs = page.get_by_role("region", name="Next").get_by_role("listitem")
    for region, feasts in (("", 5), ("DE-BW", 0)):
        page.get_by_label("Nor on the public holidays of").fill(region)
        page.get_by_role("button", name="Show the next moments").click()
        expect(runs).to_have_count(10)
        # The sixth of January is a public holiday there.
        expect(runs.filter(has_text="6 Jan")).to_have_count(feasts)
        expect(runs.filter(has_text="7 Jan")).to_have_count(10 - feasts)
    screenshot(page, "recurring-public-holidays")

    keep(page, "After Epiphany")
    row = page.get_by_role("row", name="After Epiphany")
    expect(row).to_contain_text("not on public holidays: Germany (BW)")
    expect(row).to_contain_text("7 Jan")
    expect(row).not_to_contain_text(re.compile(r"\b6 Jan"))
    row.get_by_role("button", name="After Epiphany", exact=True).click()
    expect(page.get_by_label("Nor on the public holidays of")).to_have_value("DE-BW")
    page.get_by_role("button", name="Close").click()
    remove(page, "After Epiphany")


def test_named_days_of_a_calendar_are_ticked_and_can_be_changed_by_their_boxes(
    forms: Any, page: Page, screenshot: Screenshot
) -> None:
    load = {"item": "shaft", "quantity": 4, "to": "M8"}
    asked = {"name": "Workdays", "calendar": "30 6 * * MON-SAT", "time_zone": "UTC", "transport": load}
    forms.ask("/api/schedules", asked)
    page.reload()
    row = page.get_by_role("row", name="Workdays")
    row.get_by_role("button", name="Workdays", exact=True).click()
    expect(page.locator(".recurring-day input:checked")).to_have_count(6)
    expect(page.get_by_role("checkbox", name="Sun")).not_to_be_checked()
    expect(page.get_by_label("at", exact=True)).to_have_value("06:30")
    screenshot(page, "recurring-named-days")
    page.get_by_label("Pieces each time").fill("5")
    keep(page, "Workdays", close=False)
    assert forms.ask("/api/schedules")["items"][0]["calendar"] == asked["calendar"]

    page.get_by_role("checkbox", name="Sat").uncheck()
    keep(page, "Workdays")
    expect(row).to_contain_text("Mon to Fri at 06:30")
    remove(page, "Workdays")


def test_what_is_written_while_it_is_sent_stays(page: Page) -> None:
    plan(page, "Early", "4")
    keep, pieces = page.get_by_role("button", name="Keep", exact=True), page.get_by_label("Pieces each time")
    with held(page, "**/api/schedules") as let_go:
        keep.click()
        expect(keep).to_be_disabled()
        pieces.fill("7")
        let_go()
    expect(page.get_by_text("Early is kept.")).to_be_visible()
    expect(pieces).to_have_value("7")
    # It is a change of what was kept, and nothing new.
    keep.click()
    page.get_by_role("button", name="Close").click()
    expect(page.get_by_role("row", name="Early")).to_contain_text("7 Shaft")
    remove(page, "Early")


def test_after_ten_minutes_away_the_list_says_what_was_left_out_and_what_was_made_up_for_and_why(
    sqlite_url: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    async def plan_both(house: House) -> None:
        for name, missed in (("First tour", "skip"), ("Second tour", "catch_up")):
            response = await house.client.post(PATH, json=DRAFT | {"name": name, "missed": missed})
            assert response.status_code == 201, response.text

    async def placed(house: House) -> list[dict[str, Any]]:
        await provided(house.app, Scheduler).look()
        items: list[dict[str, Any]] = (await house.get("/api/transports"))["items"]
        return items

    with open_house(sqlite_url, wall=Wall(SIX_S - 60.0)) as before:
        before.do(plan_both)
        assert before.do(placed) == []
    with open_house(sqlite_url, wall=Wall(SIX_S + 540.0), incarnation=2) as after:
        [one] = after.do(placed)
        assert (one["item"], one["called_by"]) == (BRING["item"], "Second tour")
        page = as_manager(after, open_page)
        page.goto(f"{after.url}/#recurring")
        skipped, caught_up = (page.get_by_role("row", name=name) for name in ("First tour", "Second tour"))
        expect(skipped).to_contain_text(
            "Left out: Mon 18 Mar, 06:00. The gateway or its database was away then"
        )
        expect(skipped).not_to_contain_text("T-")
        expect(caught_up).to_contain_text(
            "Made up for later, Mon 18 Mar, 06:09. The gateway or its database was away at its time"
        )
        expect(caught_up.get_by_role("link", name=one["id"])).to_be_visible()
        expect(caught_up).not_to_contain_text("Left out")
        screenshot(page, "recurring-after-an-absence")


@in_every_look
def test_it_fits_every_width(
    forms: Any, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str
) -> None:
    page = open_page(f"{forms.url}/#recurring", locale=LOCALES[language], color_scheme=theme)
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    page.locator("[popovertarget=recurring-form]").first.click()
    for kind in ("transport", "order"):
        page.locator("#recurring-kind").select_option(kind)
        for width in WIDTHS_PX:
            page.set_viewport_size({"width": width, "height": 900})
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
            screenshot(page, f"recurring-{kind}-{language}-{theme}-{width}")
