"""The management panel in a real browser, before a factory whose time stands until a test lets it pass."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from complaints import Complaints
from frames import Frames
from manager_kit import choose
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def quiet_factory(quiet: Any) -> str:
    return str(quiet.url)


@pytest.fixture
def busy_factory(busy: Any) -> str:
    return str(busy.url)


class Movement:
    """Which vehicles have moved, as the page hears it."""

    def __init__(self) -> None:
        self._where: dict[str, tuple[float, float]] = {}
        self.moved: set[str] = set()

    def two_have_moved(self, frame: dict[str, Any]) -> bool:
        """Take one frame of the stream."""
        for atv in frame.get("atvs", ()):
            here = (atv["x_m"], atv["y_m"])
            if self._where.setdefault(atv["id"], here) != here:
                self.moved.add(atv["id"])
        return len(self.moved) >= 2


MOVED_MS = 60_000
"""Where several vehicles drive, two have moved within a tenth of a second."""

PIXELS = "[...document.querySelectorAll('canvas')].map((canvas) => canvas.toDataURL()).join()"
"""Everything that is drawn on the map at this moment."""


def test_the_panel_opens_and_shows_the_whole_plant(quiet_factory: str, open_page: OpenPage) -> None:
    page = open_page(quiet_factory)
    expect(page.locator("canvas").first).to_be_visible()
    for title in ("Factory", "Orders", "Publish production"):
        expect(page.get_by_role("heading", name=title).first).to_be_visible()


def test_vehicles_move_on_the_map(busy: Any, open_page: OpenPage, screenshot: Screenshot) -> None:
    page = open_page("about:blank", visits=busy.url, reduced_motion="no-preference")
    frames = Frames(page, Movement().two_have_moved)
    page.goto(busy.url)
    expect(page.locator("canvas").first).to_be_visible()
    before = page.evaluate(PIXELS)
    with busy.going():
        frames.wait(MOVED_MS)
        page.wait_for_function(f"before => {PIXELS} !== before", arg=before)
    screenshot(page, "manager")


def test_an_order_that_is_placed_in_the_panel_is_delivered(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    page.get_by_label("Quantity").fill("4")
    page.get_by_label("Customer").fill("Hall 3")
    page.get_by_label("Reference").fill("PO-browser")
    page.get_by_role("button", name="Publish").click()
    order = page.get_by_role("listitem").filter(has_text="PO-browser")
    expect(order).to_be_visible()
    status = order.locator(".order-status")
    expect(status).to_have_text("published")
    quiet.advance_until(lambda: quiet.ask("/api/orders?q=PO-browser")["items"][0]["status"] == "delivered")
    expect(status).to_have_text("delivered")
    screenshot(page, "manager-delivered")


def test_a_quantity_that_is_no_number_is_refused_beside_its_field(
    quiet_factory: str, open_page: OpenPage
) -> None:
    page = open_page(quiet_factory)
    quantity = page.get_by_label("Quantity")
    quantity.fill("many")
    page.get_by_label("Customer").fill("Hall 3")
    page.get_by_role("button", name="Publish").click()
    expect(quantity).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#publish-quantity-wrong")).not_to_be_empty()


@pytest.mark.slow
def test_orders_and_the_fleet_are_narrowed_down_and_taken_along(
    busy_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{busy_factory}/#fleet")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(8)
    page.get_by_role("searchbox", name="Find in this list").fill("atv3")
    expect(rows).to_have_count(1)
    screenshot(page, "fleet")
    page.get_by_role("link", name="Orders").click()
    expect(rows.first).to_be_visible()
    page.get_by_role("combobox", name="Status").select_option("cancelled")
    expect(page.get_by_text("Nothing fits.")).to_be_visible()
    screenshot(page, "orders")
    with page.expect_download() as download:
        page.get_by_role("link", name="CSV").click()
    assert download.value.suggested_filename == "orders.csv"


VIEWS = ("Plant", "Orders", "Fleet", "Tasks", "Watch", "Promises", "Figures", "Audit")


@pytest.mark.slow
def test_at_200_percent_nothing_is_cut_off_sideways(
    quiet_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    # What a browser shows of 1280 x 800 when everything is twice as large (WCAG 2.2, 1.4.4 and 1.4.10).
    page = open_page(quiet_factory, viewport={"width": 640, "height": 400}, locale="de-DE")
    page.get_by_role("button", name="Management").click()
    page.get_by_label("Sprache").select_option("English")
    page.keyboard.press("Escape")
    for view in VIEWS:
        link = page.get_by_role("navigation").get_by_role("link", name=view)
        expect(link).to_be_in_viewport(ratio=1)
        link.click()
        expect(link).to_have_attribute("aria-current", "page")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), view
    screenshot(page, "manager-200-percent")


def test_the_keyboard_alone_chooses_on_the_map_and_leads_to_the_alerts(
    quiet_factory: str, open_page: OpenPage
) -> None:
    page = open_page(quiet_factory)
    choose(page, "ATV3")
    expect(page.get_by_role("region", name="ATV3")).to_be_visible()
    traffic = page.get_by_role("button", name="Traffic")
    traffic.focus()
    page.keyboard.press("Space")
    expect(traffic).to_have_attribute("aria-pressed", "true")
    page.locator(".alerts-button").focus()
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Alerts")).to_be_visible()


@pytest.mark.slow
def test_the_traffic_of_the_last_hour_is_a_layer_with_a_legend(
    busy_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(busy_factory)
    shown = page.get_by_role("combobox", name="What the lanes show")
    expect(shown).to_have_count(0)
    page.get_by_role("button", name="Traffic").click()
    expect(shown).to_be_visible()
    expect(page.get_by_text("from 1", exact=True)).to_be_visible()
    page.get_by_role("button", name="Areas").click()
    screenshot(page, "traffic")
    # What was written down is a minute old, and here perhaps nothing yet: the legend tells either.
    with page.expect_response(lambda answer: "/api/traffic?since=" in answer.url) as answered:
        page.get_by_role("combobox", name="When").select_option("in the last 24 hours")
    told = answered.value.json()
    assert told["window_s"] >= 86_400.0
    expect(
        page.get_by_text("from 1" if told["items"] else "Nothing of that kind", exact=True)
    ).to_be_visible()
    screenshot(page, "traffic-of-a-day")


def test_the_watch_shows_who_guards_whom_and_can_be_filtered(
    busy_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(busy_factory + "/#watch")
    rows = page.locator("tbody tr")
    expect(rows.first).to_be_visible()
    screenshot(page, "watch")
    carrier = rows.first.get_by_role("rowheader").inner_text().split()[0]
    page.get_by_role("searchbox", name="Find in this list").fill(carrier)
    # A carrier may hand over meanwhile; whoever is left has it in a name.
    expect(rows.filter(has_not_text=carrier)).to_have_count(0)
    page.get_by_role("button", name="Not watched").click()
    expect(page.get_by_role("button", name="Not watched")).to_have_attribute("aria-pressed", "true")


@pytest.mark.slow
def test_the_promise_ledger_can_be_sorted_and_downloaded(
    busy_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(busy_factory + "/#promises")
    expect(page.get_by_role("row", name="All vehicles")).to_be_visible()
    page.get_by_role("button", name="Vehicle", exact=True).click()
    expect(page.get_by_role("columnheader", name="Vehicle")).to_have_attribute("aria-sort", "ascending")
    names = page.get_by_role("rowheader").all_inner_texts()
    assert names == ["All vehicles", *sorted(names[1:], key=lambda name: int(name.removeprefix("ATV")))]
    for column, means in (("Half within", "Half of the deliveries"), ("95 % within", "95 of 100 deliveries")):
        head = page.get_by_role("button", name=column, exact=True)
        expect(head).to_have_accessible_description(re.compile(means))
        head.focus()
        expect(page.get_by_role("tooltip").filter(has_text=means)).to_be_visible()
        page.keyboard.press("Escape")
        expect(page.get_by_role("tooltip").filter(has_text=means)).to_be_hidden()
        head.hover()
        expect(page.get_by_role("tooltip").filter(has_text=means)).to_be_visible()
        page.mouse.move(0, 0)
    screenshot(page, "promises")
    with page.expect_download() as download:
        page.get_by_role("link", name="CSV").click()
    assert download.value.suggested_filename == "promises.csv"
    assert download.value.path().read_text().startswith("atv,delivered,on_time,")


def test_an_alert_says_what_to_do_and_is_taken_on_by_name(
    quiet: Any, quiet_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet_factory)
    broken = {"kind": "machine_broken", "machine": "M5", "reason": "spindle"}
    fault = page.request.post(f"{quiet_factory}/api/faults", data=broken)
    assert fault.ok, fault.text()
    quiet.advance(60.0)
    inbox = page.get_by_role("region", name="Needs an answer")
    # It calls for help in vain: that is no second alert.
    alert = inbox.get_by_role("listitem").filter(
        has_text="Stopped by a fault: spindle; nobody is on duty there"
    )
    expect(alert).to_contain_text("M5")
    expect(alert).to_contain_text("Send somebody there, or put somebody on duty")
    expect(inbox.get_by_role("listitem")).to_have_count(1)
    screenshot(page, "alerts")
    alert.get_by_role("button", name="Take").focus()
    page.keyboard.press("Enter")
    expect(alert).to_have_count(0)
    expect(inbox).to_be_hidden()
    page.get_by_role("link", name="1 alarm, taken").click()
    for row in page.get_by_role("row").filter(has_text="M5").all():
        expect(row).to_contain_text("Management")
    page.request.delete(f"{quiet_factory}/api/faults/{fault.json()['id']}")
    quiet.advance(10.0)
    expect(page.get_by_text("Nothing needs an answer.")).to_be_visible()


@pytest.mark.slow
def test_a_keyboard_goes_on_at_the_next_alert_when_one_is_taken(
    quiet: Any, quiet_factory: str, open_page: OpenPage
) -> None:
    page = open_page(quiet_factory)
    broken = {"kind": "machine_broken", "machine": "M5", "reason": "spindle"}
    faults = [
        page.request.post(f"{quiet_factory}/api/faults", data=broken | {"machine": machine})
        for machine in ("M5", "M6")
    ]
    quiet.advance(60.0)
    buttons = page.get_by_role("region", name="Needs an answer").get_by_role("button", name="Take")
    expect(buttons).to_have_count(2)
    last = buttons.last.get_attribute("aria-label")
    assert last is not None
    buttons.first.focus()
    page.keyboard.press("Enter")
    expect(buttons).to_have_count(1)
    expect(page.get_by_role("button", name=last)).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_role("link", name="2 alarms, taken")).to_be_focused()
    for fault in faults:
        page.request.delete(f"{quiet_factory}/api/faults/{fault.json()['id']}")
    quiet.advance(10.0)


@pytest.mark.slow
def test_the_panel_speaks_the_language_that_is_chosen_and_remembers_it(
    quiet_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet_factory, locale="es-ES")
    expect(page.get_by_role("heading", name="Lanzar producción")).to_be_visible()
    page.get_by_role("button", name="Management").click()
    expect(page.get_by_role("link", name="Panel de operario")).to_have_attribute("href", "/operator")
    page.get_by_label("Idioma").select_option("Deutsch")
    expect(page.get_by_role("heading", name="Produktion starten")).to_be_visible()
    expect(page.locator("html")).to_have_attribute("lang", "de")
    screenshot(page, "manager-de")
    page.reload()
    # The menu closes as it should: by the key that closes everything.
    page.get_by_role("button", name="Management").click()
    expect(page.get_by_role("button", name="Abmelden")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("button", name="Abmelden")).to_be_hidden()
    expect(page.get_by_role("heading", name="Produktion starten")).to_be_visible()


@pytest.mark.slow
def test_the_audit_log_can_be_narrowed_turned_over_and_downloaded(
    quiet_factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(f"{quiet_factory}/#audit")
    # More lines than a page of the log has.
    for number in range(52):
        placed = page.request.post(
            f"{quiet_factory}/api/orders",
            data={
                "customer": f"Hall {number}",
                "items": [{"product": "gear-unit-g1", "quantity": 1}],
                "release": False,
            },
        )
        assert placed.ok, placed.text()
    page.get_by_role("combobox", name="What").select_option("order placed")
    rows = page.locator("tbody tr")
    expect(rows).to_have_count(50)
    screenshot(page, "audit")
    page.get_by_role("button", name="More", exact=True).click()
    expect(page.get_by_role("button", name="Back", exact=True)).to_be_enabled()
    expect(rows).not_to_have_count(50)
    # The newest one of that page is placed here; an older one may be another test's, with a name of its own.
    only = rows.first.get_by_role("button").last
    target = only.inner_text().removeprefix("Only ")
    only.click()
    expect(rows).to_have_count(1)
    with page.expect_download() as download:
        page.get_by_role("link", name="CSV").click()
    lines = download.value.path().read_text().splitlines()
    assert lines[0].startswith("position,at,who,")
    assert len(lines) == 2
    assert target in lines[1]


@pytest.mark.slow
def test_whoever_logs_out_is_led_to_the_login_in_every_tab(
    quiet_factory: str, open_page: OpenPage, complaints: Complaints
) -> None:
    page = open_page(quiet_factory)
    other = page.context.new_page()
    other.goto(quiet_factory)
    expect(other.get_by_role("heading", name="Publish production")).to_be_visible()
    page.get_by_role("button", name="Management").click()
    page.get_by_role("button", name="Log out").click()
    page.wait_for_url("**/login")
    other.wait_for_url("**/login?next=*")
    # What the other tab asks for before it is led there, the browser tells of by itself.
    other.close()
    complaints[:] = [each for each in complaints if "status of 401" not in each]


@pytest.mark.slow
@pytest.mark.parametrize("theme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_a_busy_plant_is_shown_without_complaints_in_both_themes(
    busy_factory: str, open_page: OpenPage, screenshot: Screenshot, theme: str
) -> None:
    page = open_page(busy_factory, color_scheme=theme)
    expect(page.locator("canvas").first).to_be_visible()
    expect(page.locator(".live-age")).not_to_be_empty()
    expect(page.locator(".auction a").first).to_be_visible()
    screenshot(page, f"management-panel-{theme}")
    screenshot(page, f"live-auction-{theme}", of=".auction")
