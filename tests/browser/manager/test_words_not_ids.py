"""What stands in a page is for people: an order is called by its reference and a choice by its words, in every language."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from looks import LOCALES
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

REFERENCE = "PO-7"

COMMANDS: tuple[dict[str, Any], ...] = (
    {"kind": "stop"},
    {"kind": "acknowledge"},
    {"kind": "resume"},
    {"kind": "set_speed", "speed_frac": 0.5},
    {"kind": "take_out", "reason": "worn wheel", "after_work": True, "wait_s": 3600},
)
"""What a manager tells one vehicle; the audit log has a line of each."""

SAID = """() => {
    const all = [...document.querySelectorAll("body *")].filter((each) => !each.closest("script, style, template"));
    const texts = all.flatMap((each) => [...each.childNodes].filter(({ nodeType }) => nodeType === Node.TEXT_NODE).map(({ data }) => data));
    const told = all.flatMap((each) => ["aria-label", "title", "placeholder"].map((name) => each.getAttribute(name) ?? ""));
    return [...texts, ...told].map((each) => each.trim()).filter(Boolean);
}"""
"""All that a page says, also to whoever hears it, and what it keeps for whoever opens something."""

INTERNAL = re.compile(
    r"\bO-[0-9A-Z]{6,}|[0-9a-f]{8}-[0-9a-f]{4}-|\b[a-z]+_[a-z]+|\b(?:true|false|null|undefined|NaN)\b|\[object"
)
"""The id of an order, with which a goal's begins; that of a command; the name of a field or a choice; a value of a program."""

VIEWS = (
    "plant",
    "orders",
    "fleet",
    "tasks",
    "watch",
    "promises",
    "kpis",
    "audit",
    "alerts",
    "transports",
    "shift",
    "people",
)


HEAD_WIDTHS_PX = (1700, 1561, 1560, 1440, 1401, 1400, 1361, 1280, 1241, 1240, 1200, 1181)
"""Windows of a desk, with those where the room of the head changes."""


@pytest.fixture(scope="module")
def factory(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """An order is at work in it, and a manager has told a vehicle all kinds of things."""
    dray = start_dray("--speed", "20", "--no-demand", stepped=True)
    dray.advance(5.0)
    wanted = {"customer": "Muster GmbH", "reference": REFERENCE}
    dray.ask("/api/orders", wanted | {"items": [{"product": "gear-unit-g1", "quantity": 12}]})
    dray.advance(60.0)
    with dray.going():
        for command in COMMANDS:
            dray.ask("/api/atvs/ATV2/commands", command)
    yield dray
    assert dray.stop() == 0, dray.output()


def internal(page: Page) -> list[str]:
    """What should not stand in a page; the columns of a file have the names that stand in the file."""
    return [said for said in page.evaluate(SAID) if INTERNAL.search(said) and "CSV" not in said]


@pytest.mark.parametrize("language", LOCALES)
def test_the_head_of_every_page_has_one_row_with_the_whole_name_of_who_works_there(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, language: str
) -> None:
    page = open_page(factory.url, locale=LOCALES[language], viewport={"width": 1280, "height": 800})
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    links = page.locator("header.top").locator("nav a, .person")
    expect(links).to_have_count(11)
    name = page.locator(".person .clip")
    expect(name).to_have_text("Management")
    for width in HEAD_WIDTHS_PX:
        page.set_viewport_size({"width": width, "height": 800})
        middles = links.evaluate_all(
            "all => all.map((each) => { const box = each.getBoundingClientRect(); return (box.top + box.bottom) / 2; })"
        )
        assert max(middles) - min(middles) < 4.0, width
        assert name.evaluate("each => each.scrollWidth <= each.clientWidth"), width
    screenshot(page, f"head-{language}", audited=False)


@pytest.mark.parametrize("language", LOCALES)
def test_no_page_says_an_id_or_the_name_of_a_field(
    factory: Any, open_page: OpenPage, screenshot: Screenshot, language: str
) -> None:
    page = open_page(factory.url, locale=LOCALES[language], viewport={"width": 1440, "height": 900})
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    for view in VIEWS:
        page.evaluate("view => { location.hash = `#${view}`; }", view)
        expect(page.locator("[aria-busy=true]")).to_have_count(0)
        if view == "tasks":
            # A goal has the name of its order.
            expect(page.locator("tbody").get_by_text(re.compile(f"^{REFERENCE}-")).first).to_be_visible()
        if view == "audit":
            expect(page.locator("tbody tr").filter(has_text="ATV2")).to_have_count(len(COMMANDS))
        screenshot(page, f"words-{view}-{language}", audited=False)
        assert internal(page) == [], view
    page.evaluate("location.hash = '#orders'")
    page.get_by_role("link", name=REFERENCE).first.click()
    expect(page.get_by_role("heading", name=re.compile(REFERENCE))).to_be_visible()
    expect(page.locator("[aria-busy=true]")).to_have_count(0)
    screenshot(page, f"words-order-{language}", audited=False)
    # Its own page tells its id once, for who asks for it over REST.
    assert [said for said in internal(page) if not said.startswith("/ O-")] == []
