"""The page of one order in a real browser: from what was made to who has brought it, and its customer's links."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import pytest
from complaints import Complaints
from looks import THEMES, WIDTHS_PX
from manager_kit import iso, kept_moment
from playwright.sync_api import Page, Route, expect

ROOT = Path(__file__).resolve().parents[3]

OpenPage = Callable[..., Page]
Screenshot = Callable[[Page, str], Path]


@pytest.fixture
def factory(quiet: Any) -> str:
    return str(quiet.url)


def publish(page: Page, customer: str, reference: str, quantity: int) -> None:
    page.get_by_label("Quantity").fill(str(quantity))
    page.get_by_label("Customer").fill(customer)
    page.get_by_label("Reference").fill(reference)
    page.get_by_role("button", name="Publish", exact=True).click()
    expect(page.locator(".outcome-good")).to_contain_text("Published as")


def place(quiet: Any, reference: str, quantity: int, due_in_s: float) -> str:
    """Place an order that is due so many seconds of the wall clock from now; its id."""
    product = quiet.ask("/api/products")["items"][0]["id"]
    wanted = {"customer": "Waterworks South", "reference": reference, "due_at": iso(quiet.wall_s + due_in_s)}
    items = [{"product": product, "quantity": quantity}]
    return str(quiet.ask("/api/orders", wanted | {"items": items})["id"])


STEP_S = 10.0
"""Of the factory's time, from look to look: what is looked for here comes after minutes, and lasts longer than that."""


LATE = (40, 30.0)
"""More pieces than can be delivered until then."""


def advance_until_carried(quiet: Any, order: str) -> None:
    """Let time pass until goods of an order are to be carried; its page, which asks now and then, may show it later."""
    story = f"/api/orders/{order}/timeline"
    quiet.advance_until(lambda: bool(quiet.ask(story)["transports"]), step_s=STEP_S)


def test_an_order_tells_its_whole_story_on_a_page_of_its_own(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory)
    publish(page, "Waterworks South", "PO-48213", 10)
    page.get_by_role("link", name="Orders", exact=True).click()
    page.get_by_role("link", name="PO-48213").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("PO-48213")
    address = page.evaluate("location.hash")
    assert re.fullmatch(r"#orders/O-.+", address)
    expect(page.get_by_role("link", name="Orders", exact=True).first).to_have_attribute(
        "aria-current", "page"
    )

    # From the machine that takes it to the vehicle that hands it over.
    lanes, tag = page.locator(".lane-transport"), page.locator(".order-head .tag").first
    quiet.advance_until(
        lambda: quiet.ask(f"/api/orders/{address[8:]}")["status"] == "in_delivery", step_s=STEP_S
    )
    expect(lanes.first).to_be_visible()
    expect(tag).to_have_text("being delivered")
    quiet.advance_until(
        lambda: quiet.ask(f"/api/orders/{address[8:]}")["status"] == "delivered", step_s=STEP_S
    )
    expect(tag).to_have_text("delivered")
    expect(page.locator(".order-figures")).to_contain_text("10 of 10")
    moments = page.locator(".order-moments li")
    expect(moments.first).to_contain_text("All of it is delivered")
    lanes.first.click()
    expect(page.locator(".order-told")).to_contain_text(re.compile(r"ATV\d+ handed it over at .+ at "))
    expect(page.locator(".order-moments li.chosen").first).to_be_visible()
    screenshot(page, "order-page")
    page.get_by_role("button", name="Problems").click()
    expect(page.locator(".order-moments")).to_contain_text("Nothing of that kind has happened.")

    # Its address leads here again, and the browser's way back leads to the list.
    page.reload()
    expect(page.get_by_role("heading", level=1)).to_have_text("PO-48213")
    page.get_by_role("link", name="Orders", exact=True).first.click()
    expect(page.get_by_role("row").filter(has_text="PO-48213")).to_be_visible()
    page.go_back()
    expect(page.get_by_role("heading", level=1)).to_have_text("PO-48213")


NOW_PLUS_AN_HOUR = """atS => {
    const at = new Date((atS + 3600) * 1000);
    return new Date(at.getTime() - at.getTimezoneOffset() * 60000).toISOString().slice(0, 16);
}"""
"""As a field of date and time wants it."""


def test_the_axis_says_now_due_and_when_all_is_expected(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory, viewport={"width": 1440, "height": 900})
    due = page.evaluate(NOW_PLUS_AN_HOUR, quiet.wall_s)
    page.get_by_role("textbox", name="Due (optional)").fill(due)
    publish(page, "Waterworks South", "PO-AXIS", 60)
    page.get_by_role("link", name="Orders", exact=True).click()
    page.get_by_role("link", name="PO-AXIS").click()
    expect(page).to_have_url(re.compile(r"#orders/O-.+"))
    story = f"/api/orders/{page.url.rpartition('#orders/')[2]}/timeline"
    quiet.advance_until(lambda: quiet.ask(story)["expected"] is not None, step_s=STEP_S)
    signs = page.locator(".lane-signs")
    expect(signs).to_contain_text(re.compile(r"now \d\d:\d\d"))
    expect(signs).to_contain_text(f"due {due[-5:]}")
    expected = page.locator(".lane").filter(has=page.locator(".lane-expected"))
    expect(expected).to_contain_text(re.compile(r"Deliveredall, expected \d\d:\d\d to \d\d:\d\d"))
    legend = page.locator(".lane-legend")
    for named in ("delivery expected", "now", "due"):
        expect(legend).to_contain_text(named)
    for theme in THEMES:
        page.emulate_media(color_scheme=theme)
        screenshot(page, f"order-axis-{theme}")


def test_it_says_how_the_expected_time_has_moved(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    order = place(quiet, "PO-MOVED", 30, 3600.0)
    quiet.advance_until(lambda: bool(quiet.ask(f"/api/orders/{order}/timeline")["estimates"]), step_s=STEP_S)
    kept = quiet.ask(f"/api/orders/{order}/timeline")["estimates"]
    assert kept[0]["cause"] == "first"
    page = open_page(f"{factory}/#orders/{order}", viewport={"width": 1440, "height": 900})
    card = page.get_by_role("region", name="How the expected time moved")
    expect(card.get_by_role("img")).to_have_accessible_name(
        re.compile(r"Expected at first \d\d:\d\d to \d\d:\d\d")
    )
    expect(card.locator(".estimates-step")).to_have_count(len(kept))
    quiet.ask(f"/api/orders/{order}/cancel", {})
    expect(page.locator(".order-head .tag").first).to_have_text("cancelled")
    # An order that has ended tells it, too.
    expect(card.locator(".estimates-step").first).to_be_visible()
    screenshot(page, "order-estimates")


def test_it_says_that_more_urgent_orders_have_moved_a_promise_and_so_does_the_customers_page(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    order = place(quiet, "PO-PASSED", 80, 6 * 3600.0)
    story = f"/api/orders/{order}/timeline"
    quiet.advance_until(lambda: bool(quiet.ask(story)["goals"]), step_s=STEP_S)
    product = quiet.ask("/api/products")["items"][0]["id"]

    def is_moved() -> bool:
        return any(goal["came_before"] for goal in quiet.ask(story)["goals"])

    for number in range(12):
        if is_moved():
            break
        items = [{"product": product, "quantity": 20}]
        wanted = {"customer": "Nordwerk", "reference": f"PO-URGENT-{number}", "priority": "urgent"}
        quiet.ask("/api/orders", wanted | {"items": items})
        quiet.advance(STEP_S)
    assert is_moved()
    page = open_page(f"{factory}/#orders/{order}", viewport={"width": 1440, "height": 900})
    expect(page.locator(".lane-note").first).to_contain_text(
        re.compile(r"promised by \d\d:\d\d, moved from \d\d:\d\d: \d+ more urgent goals? came before it")
    )
    screenshot(page, "order-passed")
    customers = open_page(quiet.ask(f"/api/orders/{order}")["tracking_url"])
    expect(customers.get_by_text("More urgent work came before this order")).to_be_visible()
    screenshot(customers, "order-passed-customer")


def test_what_is_chosen_on_it_stands_in_its_address(quiet: Any, factory: str, open_page: OpenPage) -> None:
    page = open_page(factory)
    publish(page, "Waterworks South", "PO-CHOSEN", 10)
    page.get_by_role("link", name="Orders", exact=True).click()
    page.get_by_role("link", name="PO-CHOSEN").click()
    expect(page).to_have_url(re.compile(r"#orders/O-[^?]+$"))
    advance_until_carried(quiet, page.url.rpartition("#orders/")[2])
    transport, told = page.locator(".lane-transport").first, page.locator(".order-told")
    problems = page.get_by_role("button", name="Problems")
    transport.click()
    expect(page).to_have_url(re.compile(r"#orders/O-[^?]+\?transport=[^&]+$"))
    problems.click()
    expect(page).to_have_url(re.compile(r"\?transport=[^&]+&events=problems$"))
    sent = page.url
    page.reload()
    expect(transport).to_have_attribute("aria-pressed", "true")
    expect(problems).to_have_attribute("aria-pressed", "true")
    page.go_back()
    expect(problems).to_have_attribute("aria-pressed", "false")
    expect(told).to_be_visible()
    page.go_back()
    expect(told).to_have_count(0)
    page.go_forward()
    expect(told).to_be_visible()
    other = open_page(sent)
    expect(other.locator(".lane-transport").first).to_have_attribute("aria-pressed", "true")
    expect(other.get_by_role("button", name="Problems")).to_have_attribute("aria-pressed", "true")
    # One that names something else says so.
    other.goto(f"{sent.partition('?')[0]}?transport=M4-999")
    expect(other.get_by_text("The transport that the link names is not known here.")).to_be_visible()
    expect(other.locator(".order-told")).to_have_count(0)


def test_links_for_the_customer_are_made_and_taken_back_there(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory)
    publish(page, "Nordwerk", "PO-7", 5)
    # What was published leads to its page.
    page.locator(".outcome-good").get_by_role("link").click()
    links = page.locator(".order-links")
    expect(links).to_contain_text("1 valid")
    links.get_by_role("button", name="Make a link").click()
    expect(links).to_contain_text("2 valid")
    address = links.get_by_label("Address of the customer").input_value()
    assert page.request.get(address).status == 200
    screenshot(page, "order-links")
    links.get_by_role("button", name="Take all back").click()
    safe = links.get_by_role("button", name="Keep links")
    expect(safe).to_be_focused()
    links.get_by_role("button", name="Take links back").click()
    expect(links).to_contain_text("0 valid")
    assert "taken back" in page.request.get(address).text() or page.request.get(address).status >= 400


def test_an_order_that_there_is_not_says_so(
    factory: str, open_page: OpenPage, complaints: Complaints
) -> None:
    page = open_page(factory + "/#orders/O-1M9K3X2A4-K7QM")
    expect(page.get_by_role("main")).to_contain_text("could not be read")
    page.get_by_role("link", name="All orders").click()
    expect(page.get_by_role("heading", level=1)).to_have_text("Orders")
    # The browser tells of every 404 by itself, and of nothing else.
    assert all("status of 404" in each for each in complaints)
    complaints.clear()


COLOUR_OF = """([selector, name]) => getComputedStyle(document.querySelector(selector))[name]"""
WHITE = "rgb(255, 255, 255)"


def test_it_prints_light_from_the_dark_theme_and_without_what_can_be_clicked(
    quiet: Any, factory: str, open_page: OpenPage, tmp_path: Path
) -> None:
    order = place(quiet, "PO-PAPER", 10, 3600.0)
    page = open_page(
        f"{factory}/#orders/{order}", viewport={"width": 1440, "height": 900}, color_scheme="dark"
    )
    advance_until_carried(quiet, order)
    page.locator(".lane-transport").first.click()
    expect(page.locator(".order-told")).to_be_visible()

    def colour(selector: str, name: str) -> str:
        return str(page.evaluate(COLOUR_OF, [selector, name]))

    assert colour(".order-lanes", "backgroundColor") != WHITE
    on_screen = colour(".lane-axis ~ div .lane-goal", "color")
    page.emulate_media(media="print", color_scheme="dark")
    # Whether the system is dark, or somebody has chosen it here.
    for theme in (None, "dark"):
        page.evaluate("theme => theme && (document.documentElement.dataset.theme = theme)", theme)
        for selector in ("body", ".app", ".order-head", ".order-lanes", ".order-moments", ".order-told"):
            assert colour(selector, "backgroundColor") in (WHITE, "rgba(0, 0, 0, 0)"), selector
        assert colour("body", "backgroundColor") == WHITE
        assert colour("#order-title", "color") == "rgb(29, 36, 43)" != on_screen
        # Bars are printed as they are drawn: dark on white.
        assert colour(".lane-legend .lane-carry", "backgroundColor") == "rgb(60, 70, 80)"
        assert colour(".lane-bar", "printColorAdjust") == "exact"
    for what in (".top", ".order-deeds", ".order-change", ".order-links", ".order-moments .segments"):
        expect(page.locator(what)).to_be_hidden()
    expect(page.locator(".order-told")).to_be_visible()
    expect(page.locator(".lane-signs")).to_contain_text("due ")
    pdf = page.pdf(path=tmp_path / "order.pdf", format="A4")
    assert len(re.findall(rb"/Type\s*/Page\b", pdf)) >= 1
    page.set_viewport_size({"width": 794, "height": 1123})
    page.screenshot(path=ROOT / "artifacts/screenshots/order-paper.png", full_page=True)


def test_whom_a_change_would_let_wait_is_a_way_to_that_order(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    passed = place(quiet, "PO-PASSED", 10, 200.0)
    order = place(quiet, "PO-PASSING", 10, 3600.0)
    page = open_page(f"{factory}/#orders/{order}", viewport={"width": 1440, "height": 900})
    form = page.locator(".order-change")
    form.get_by_label("Priority").select_option("urgent")
    expect(form).to_contain_text("It would pass")
    screenshot(page, "order-passing")
    with page.expect_popup() as opened:
        form.get_by_role("link", name="PO-PASSED (opens in a new tab)").click()
    expect(opened.value.get_by_role("heading", level=1)).to_have_text("PO-PASSED")
    opened.value.close()
    # What is written and not saved stays.
    expect(form.get_by_label("Priority")).to_have_value("urgent")
    for each in (passed, order):
        quiet.ask(f"/api/orders/{each}/cancel", {})


def test_on_a_laptop_what_saves_a_change_is_in_sight(quiet: Any, factory: str, open_page: OpenPage) -> None:
    order = place(quiet, "PO-SAVED", 60, 3600.0)
    story = f"/api/orders/{order}/timeline"
    quiet.advance_until(lambda: bool(quiet.ask(story)["estimates"]), step_s=STEP_S)
    page = open_page(f"{factory}/#orders/{order}")
    expect(page.locator(".order-estimates")).to_be_visible()
    for name in ("Undo", "Save changes"):
        button = page.locator(".order-change").get_by_role("button", name=name)
        expect(button).to_be_in_viewport(ratio=1)
    quiet.ask(f"/api/orders/{order}/cancel", {})


PRINTED = """addEventListener("afterprint", () => {
    window.printed = [".order-moments li", ".order-estimates li"].map(rows => document.querySelectorAll(rows).length);
});
window.print = () => {
    dispatchEvent(new Event("beforeprint"));
    dispatchEvent(new Event("afterprint"));
};"""
"""How many rows stood on the page that was printed; `print()` leaves no time to draw anew, as in a browser with a head."""


def test_on_paper_nothing_waits_for_a_click(quiet: Any, factory: str, open_page: OpenPage) -> None:
    order = place(quiet, "PO-EVENTS", 60, 3600.0)
    path = f"/api/orders/{order}/timeline"
    quiet.advance_until(lambda: (told := quiet.ask(path))["moments"] and told["estimates"], step_s=STEP_S)

    def tell_more(route: Route) -> None:
        """As of an order of which much is told."""
        answer = route.fetch()
        story = answer.json()
        [moment, *_], [estimate, *_] = story["moments"], story["estimates"]
        story["moments"] = [moment | {"at_s": moment["at_s"] + n} for n in range(100)]
        story["estimates"] = [estimate] + [
            estimate | {"at_s": estimate["at_s"] + n, "cause": "moved"} for n in range(1, 10)
        ]
        route.fulfill(response=answer, json=story)

    page = open_page("about:blank", visits=factory)
    page.add_init_script(PRINTED)
    page.route(f"**{path}", tell_more)
    page.goto(f"{factory}/#orders/{order}")
    events, moves = page.locator(".order-moments li"), page.locator(".order-estimates li")
    expect(events).to_have_count(40)
    expect(moves).to_have_count(5)
    for way in ("menu", "button"):
        page.evaluate("() => { window.printed = null; }")
        if way == "menu":
            page.pdf(format="A4")
        else:
            page.get_by_role("button", name="Print").click()
        printed = page.wait_for_function("() => window.printed")
        assert printed.json_value() == [100, 9]
        expect(events).to_have_count(40)
        expect(moves).to_have_count(5)


CLOCKS_OVERLAP = """() => {
    const clocks = [...document.querySelectorAll(".lane-tick")].filter((each) => getComputedStyle(each).visibility === "visible");
    const boxes = clocks.map((each) => each.getBoundingClientRect());
    return boxes.some(({ left }, i) => i > 0 && left < boxes[i - 1].right);
}"""
"""Whether the clock of one moment lies over that of the next."""


def test_the_page_fits(quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot) -> None:
    page = open_page(factory)
    for width in WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 900})
        page.goto(f"{factory}/#plant")
        publish(page, "A customer whose name is long enough for two lines on a telephone", f"PO-{width}", 10)
        quiet.advance(10.0)
        for theme in THEMES:
            page.emulate_media(color_scheme=theme)
            # It is drawn anew for each.
            page.goto(f"{factory}/#orders")
            page.get_by_role("link", name=f"PO-{width}").click()
            expect(page.locator(".lane-goal").first).to_be_visible()
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
            assert page.evaluate("document.querySelector('.order-page').scrollWidth <= innerWidth"), width
            assert not page.evaluate(CLOCKS_OVERLAP), width
            screenshot(page, f"order-page-{width}-{theme}")


def test_an_alert_about_an_order_leads_to_its_page(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    place(quiet, "PO-LATE", *LATE)
    page = open_page(factory)
    quiet.advance_until(
        lambda: any(each["kind"] == "order_late" for each in quiet.ask("/api/alerts")["items"]), step_s=STEP_S
    )
    heading = page.get_by_role("heading", level=1)
    page.locator(".inbox").get_by_role("link", name="Show PO-LATE").click()
    expect(heading).to_have_text("PO-LATE")
    page.goto(f"{factory}/#alerts")
    page.get_by_role("link", name="Show PO-LATE").click()
    expect(heading).to_have_text("PO-LATE")
    # And of what was: the log below, and the picture of the past.
    page.goto(f"{factory}/#alerts")
    log = page.get_by_role("region", name="All alerts so far")
    expect(log.get_by_role("link", name="PO-LATE", exact=True)).to_be_visible()
    for theme in THEMES:
        page.emulate_media(color_scheme=theme)
        screenshot(page, f"alerts-order-{theme}")
    log.get_by_role("link", name="PO-LATE", exact=True).click()
    expect(heading).to_have_text("PO-LATE")


PAST_S = 10.0
"""After so long a moment is past for every panel."""


def test_the_past_leads_to_the_page_of_an_order_that_was_late(
    quiet: Any, factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    order = place(quiet, "PO-PAST", *LATE)
    marks: list[dict[str, Any]] = []

    def marked() -> bool:
        span = urlencode({"since": iso(quiet.wall_s - 600), "until": iso(quiet.wall_s)})
        found = quiet.ask(f"/api/replay/overview?{span}")["marks"]
        marks[:] = [each for each in found if each["order"] == order]
        return bool(marks)

    quiet.advance_until(marked, step_s=STEP_S)
    # The past ends two seconds before now.
    quiet.advance_until(lambda: quiet.wall_s > marks[0]["at_s"] + PAST_S, step_s=STEP_S)
    kept_moment(quiet)
    page = open_page(f"{factory}/#replay/{marks[0]['at_s']:.1f}")
    named = page.locator(".replay-mark").get_by_role("link", name="PO-PAST")
    expect(named).to_be_visible()
    for theme in THEMES:
        page.emulate_media(color_scheme=theme)
        screenshot(page, f"replay-order-{theme}")
    named.click()
    expect(page.get_by_role("heading", level=1)).to_have_text("PO-PAST")
