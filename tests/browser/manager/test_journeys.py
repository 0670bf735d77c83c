"""What people do from end to end, with the mouse and with the keyboard alone: an order that was late, a link for a colleague, a link for the customer."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import datetime
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from accessibility import violations
from looks import LOCALES, THEMES
from manager_kit import iso
from playwright.sync_api import Locator, Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

REFERENCE = "PO-TUESDAY"

STEPS_MOST = 200
"""Presses of Tab to anything on a page: what is further is not reached by anybody."""

WIDTHS_PX = (390, 1024, 1440, 2560)

SOON = (("keyboard", "es", "light", 390), ("mouse", "en", "dark", 2560))
"""In `make test`."""


def hands() -> Iterator[Any]:
    """By what, in which language and theme, and how wide (pixels): two ways in `make test`; in `make test-long` so many that every two of these
    have met; all of them in `make campaign`."""
    for by, (of, language), theme, (at, width_px) in product(
        ("mouse", "keyboard"), enumerate(LOCALES), THEMES, enumerate(WIDTHS_PX)
    ):
        way = (by, language, theme, width_px)
        is_one = (by == "keyboard") == ((of + at) % 2 == 0) and (theme == "light") == (
            (of + at // 2) % 2 == 0
        )
        later = [] if way in SOON else [pytest.mark.slow if is_one else pytest.mark.campaign]
        yield pytest.param(*way, marks=later)


WORDS = {
    "en": {"late": "late", "took over": " over from ", "taken back": "This link was taken back"},
    "de": {"late": "verspätet", "took over": " übernommen", "taken back": "Dieser Link wurde zurückgenommen"},
    "es": {"late": "con retraso", "took over": " tomó ", "taken back": "Este enlace ha sido retirado"},
}
"""What the panel says."""


class Hands:
    """Somebody before a page, with a mouse or without one.

    Args:
        page: where.
        by: `mouse` or `keyboard`.
    """

    def __init__(self, page: Page, by: str) -> None:
        self.page, self._by = page, by

    def reach(self, there: Locator) -> None:
        """Stand on something, by Tab where there is no mouse."""
        expect(there).to_be_visible()
        if self._by == "mouse":
            there.hover()
            return
        for _ in range(STEPS_MOST):
            if there.evaluate("it => it === document.activeElement"):
                return
            self.page.keyboard.press("Tab")
        raise AssertionError(f"Tab does not lead to {there}")

    def use(self, there: Locator, key: str = "Enter") -> None:
        """Click it, or press a key on it."""
        self.reach(there)
        if self._by == "mouse":
            there.click()
        else:
            self.page.keyboard.press(key)

    def write_day(self, there: Locator, day: datetime) -> None:
        """Write into a field of a day. Its parts stand as the browser itself writes a day, not the page: month, day, year."""
        if self._by == "mouse":
            there.click(position={"x": 12, "y": 12})
        else:
            self.reach(there)
        self.page.keyboard.type(f"{day:%m%d%Y}")

    def write(self, there: Locator, text: str) -> None:
        """Write into a field, letter by letter."""
        if self._by == "mouse":
            there.click()
        else:
            self.reach(there)
        self.page.keyboard.type(text)


DAY = """atS => {
    const at = new Date(atS * 1000);
    return [at.getFullYear(), at.getMonth() + 1, at.getDate()].map(part => String(part).padStart(2, "0")).join("-");
}"""
"""The day of a moment where the browser is."""

WEEK_S = 7 * 86_400.0


@pytest.fixture(scope="module")
def factory(start_dray: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A factory with an order that is late because its carrier fell silent on its way.

    The same customer has four others: of a week before, of a week after, of another reference, and one that is not late.
    """
    file = tmp_path_factory.mktemp("journeys") / "dray.db"
    dray = start_dray("--speed", "20", "--no-demand", url=f"sqlite:///{file}", stepped=True)
    # Everybody has been heard.
    dray.advance(5.0)
    before, after = (place(dray, f"{REFERENCE}-{when}", release=False) for when in ("BEFORE", "AFTER"))
    with closing(sqlite3.connect(file)) as base, base:
        moved = "UPDATE orders SET created_at_s = created_at_s + ?1, due_at_s = due_at_s + ?1 WHERE id = ?2"
        base.executemany(moved, [(-WEEK_S, before), (WEEK_S, after)])
    place(dray, "PO-MONDAY", release=False)
    place(dray, f"{REFERENCE}-IN-TIME", due_in_s=WEEK_S, release=False)
    late = place(dray, REFERENCE)

    def carrier() -> str:
        """Who carries for it, or is on its way to fetch."""
        ways = dray.ask(f"/api/orders/{late}/timeline")["transports"]
        legs = [leg for way in ways for leg in way["legs"] if leg["until_at_s"] is None]
        return str(next((leg["carrier"] for leg in legs), ""))

    dray.advance_until(lambda: carrier() != "", step_s=6.0)
    dray.ask("/api/faults", {"kind": "powered_off", "agent": carrier()})
    dray.advance_until(lambda: dray.ask(f"/api/orders/{late}")["status"] == "delivered", step_s=10.0)
    yield dray
    assert dray.stop() == 0, dray.output()


def place(dray: Any, reference: str, due_in_s: float = 2.0, **more: Any) -> str:
    """Place an order, due too soon unless more time is given; its id."""
    items = [{"product": dray.ask("/api/products")["items"][0]["id"], "quantity": 2}]
    due = iso(dray.wall_s + due_in_s)
    wanted = {"customer": "Waterworks South", "reference": reference, "due_at": due, "items": items}
    return str(dray.ask("/api/orders", wanted | more)["id"])


@pytest.mark.parametrize(("by", "language", "theme", "width_px"), list(hands()))
def test_a_late_order_is_found_and_told_why_shown_to_a_colleague_and_to_its_customer(
    factory: Any,
    open_page: OpenPage,
    screenshot: Screenshot,
    by: str,
    language: str,
    theme: str,
    width_px: int,
) -> None:
    look = {
        "locale": LOCALES[language],
        "color_scheme": theme,
        "viewport": {"width": width_px, "height": 900},
    }
    page = open_page(factory.url, permissions=["clipboard-read", "clipboard-write"], **look)
    hands, says = Hands(page, by), WORDS[language]
    kept = f"journey-{by}-{language}-{theme}-{width_px}"

    # Find the order of that day, and say why it was late.
    hands.use(page.locator(".top a[href='#orders']"))
    rows = page.locator("main tbody tr")
    expect(rows).to_have_count(5)
    # Each filter leaves out one more.
    hands.write(page.locator("main input[type=search]"), "tuesday")
    expect(rows).to_have_count(4)
    day = datetime.fromisoformat(page.evaluate(DAY, factory.wall_s))
    since, until = (page.locator("main input[type=date]").nth(at) for at in (0, 1))
    hands.write_day(since, day)
    expect(rows).to_have_count(3)
    hands.write_day(until, day)
    expect(rows).to_have_count(2)
    expect(page).to_have_url(re.compile(rf"since={day:%F}&until={day:%F}"))
    hands.use(page.locator("label", has_text=says["late"]).locator("input[type=checkbox]"), "Space")
    expect(page).to_have_url(re.compile(r"late=yes"))
    expect(rows).to_have_count(1)
    screenshot(page, f"{kept}-list")
    hands.use(rows.get_by_role("link", name=REFERENCE))
    expect(page.get_by_role("heading", level=1)).to_have_text(REFERENCE)
    expect(page.locator(".order-head")).to_contain_text(says["late"])
    hands.use(page.locator(".order-moments .segments button").last)
    moments = page.locator(".order-moments li")
    expect(moments.first).to_contain_text(says["took over"])
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert violations(page) == []
    screenshot(page, f"{kept}-order")

    # Send a colleague what is seen: the chosen transport and what is looked for stand in the address.
    hands.use(moments.first.locator("button.moment-text"))
    expect(page.locator(".order-told")).to_be_visible()
    colleague = open_page(page.url, **look)
    told = page.locator(".order-told p").inner_text()
    expect(colleague.locator(".order-told p")).to_have_text(told)
    expect(colleague.locator(".order-moments .segments button").last).to_have_attribute(
        "aria-pressed", "true"
    )

    # Give the customer a link, and take it back.
    links = page.locator(".order-links")
    make, take_back = (links.locator(".order-actions").last.locator("button").nth(at) for at in (0, 1))
    hands.use(make)
    field = links.locator("input[readonly]")
    address = field.input_value()
    hands.use(links.locator("button").first)
    assert page.evaluate("navigator.clipboard.readText()") == address
    customer = open_page(address, who=None, **look)
    expect(customer.locator("body")).to_contain_text(REFERENCE)
    hands.use(take_back)
    sure = links.get_by_role("group").locator("button")
    expect(sure.first).to_be_focused()
    screenshot(page, f"{kept}-sure")
    hands.use(sure.last)
    expect(field).to_have_count(0)
    customer.reload()
    expect(customer.locator("body")).to_contain_text(says["taken back"])
    expect(customer.locator("body")).not_to_contain_text(REFERENCE)
