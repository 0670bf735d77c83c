"""Every state that a customer can find an order in: shown as it is, and fit for a telephone and a desk."""

from __future__ import annotations

import re
import sys
from collections.abc import Awaitable, Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from variants import later, variants

sys.path.insert(0, str(Path(__file__).parents[2] / "gateway/kits"))

from gateway_kit import OTHER_PRODUCT, PRODUCT, House
from tracking_kit import MACHINE, OTHER_MACHINE, Story
from wall_clock import NOW_S

from dray.messages.heartbeat import MachineStatus

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PHONE, DESK = {"width": 390, "height": 844}, {"width": 1280, "height": 800}

LOOKS = {
    "phone-light-en": {"viewport": PHONE, "color_scheme": "light", "locale": "en-GB"},
    "desk-dark-de": {"viewport": DESK, "color_scheme": "dark", "locale": "de-DE"},
}


@pytest.fixture
def factory(sqlite_url: str) -> Iterator[OpenHouse]:
    """A gateway to which the test tells what happens in its factory."""
    with open_house(sqlite_url) as house:
        yield house


# --- the states --------------------------------------------------------------------------------------

Tell = Callable[[House], Awaitable[Story]]


def due(after_s: float) -> str:
    return datetime.fromtimestamp(NOW_S + after_s, UTC).isoformat()


async def order(house: House, **fields: Any) -> Story:
    return await Story.begin(house, **{"reference": "2026-1187", **fields})


async def stored(house: House) -> Story:
    return await order(house, release=False, due_at=due(86_400))


async def placed(house: House) -> Story:
    return await order(house, reference=None)


async def planned(house: House) -> Story:
    story = await order(house, due_at=due(3600))
    await story.planned(finish_s=700.0)
    story.now(100.0)
    # Another goal comes first.
    story.beat(MACHINE, 100.0, goal="strategist.1-1")
    return story


async def in_production(
    house: House, status: MachineStatus = MachineStatus.PRODUCING, **fields: Any
) -> Story:
    story = await order(house, **{"due_at": due(3600), **fields})
    await story.planned()
    await story.making(26, status)
    return story


async def perhaps_late(house: House) -> Story:
    return await in_production(house, MachineStatus.STARVED, due_at=due(525))


async def late(house: House) -> Story:
    story = await in_production(house, due_at=due(400))
    await story.lost(380.0)
    await story.planned("strategist.1-8", OTHER_MACHINE, finish_s=900.0)
    story.now(390.0)
    story.beat(OTHER_MACHINE, 390.0, goal="strategist.1-8")
    return story


async def broken(house: House) -> Story:
    return await in_production(house, MachineStatus.ERROR)


async def impossible(house: House) -> Story:
    story = await order(house, due_at=due(3600))
    await story.waiting(50.0)
    return story


async def on_its_way(house: House) -> Story:
    story = await order(house, due_at=due(3600))
    await story.planned()
    await story.making(40)
    await story.leaving(520.0)
    await story.arrived(20, 560.0)
    return story


async def delivered(house: House, **fields: Any) -> Story:
    story = await order(house, **{"due_at": due(3600), **fields})
    await story.planned()
    await story.making(40)
    await story.leaving(520.0)
    await story.arrived(40, 600.0)
    return story


async def delivered_late(house: House) -> Story:
    return await delivered(house, due_at=due(300))


async def cancelled(house: House) -> Story:
    story = await in_production(house)
    await house.client.post(f"/api/orders/{story.order['id']}/cancel")
    return story


async def several_parts(house: House) -> Story:
    items = [{"product": PRODUCT, "quantity": 1200}, {"product": OTHER_PRODUCT, "quantity": 5}]
    return await order(
        house, items=items, reference="Rahmenvertrag-2026/Q4-Hydraulikaggregate-Ersatzteile-0815"
    )


async def taken_back(house: House) -> Story:
    story = await order(house)
    async with house.store.write() as work:
        await work.links.revoke(story.token, NOW_S)
    return story


async def expired(house: House) -> Story:
    story = await delivered(house)
    story.now(365 * 86_400.0)
    return story


class State(NamedTuple):
    """How an order comes into a state, and what its customer then reads first."""

    tell: Tell
    answer: str
    tag: str = ""
    reason: str = ""


STATES = {
    "stored": State(stored, "Not started yet", reason="Production has not been asked to begin"),
    "placed": State(placed, "Cannot be said yet"),
    "planned": State(planned, r"Today, 17:58 . 18:04"),
    "in-production": State(in_production, r"Today, 17:5\d . 17:5\d"),
    "perhaps-late": State(perhaps_late, "Today", "May be later than requested", "waits for material"),
    "late": State(late, "Today", "Later than requested", "another one makes what was missing"),
    "broken": State(broken, "Cannot be said yet", reason="out of order"),
    "impossible": State(impossible, "Cannot be said yet", reason="No machine"),
    "on-its-way": State(on_its_way, "Today"),
    "delivered": State(delivered, "Today, 17:56"),
    "delivered-late": State(delivered_late, "Today, 17:56", "Delivered later than requested"),
    "cancelled": State(cancelled, "Today"),
    "several-parts": State(several_parts, "Cannot be said yet"),
}


def open_at(factory: OpenHouse, open_page: OpenPage, story: Story, look: dict[str, Any]) -> Page:
    """The page, at the time of the story, in Greenwich."""
    page = open_page("about:blank", timezone_id="Etc/GMT", **look)
    page.clock.install(time=story.house.wall.now_s)
    page.goto(factory.url + story.path)
    return page


@pytest.mark.parametrize("name", variants(STATES, "late", "delivered"))
def test_every_state_is_told_in_the_first_lines_and_fits_every_screen(
    factory: OpenHouse, open_page: OpenPage, screenshot: Screenshot, name: str
) -> None:
    state = STATES[name]
    story = factory.do(state.tell)
    for look, options in LOOKS.items():
        page = open_at(factory, open_page, story, options)
        if look.endswith("en"):
            expect(page.locator(".eta")).to_have_text(re.compile(state.answer))
            expect(page.locator(".tag")).to_have_text([state.tag] if state.tag else [])
            expect(page.locator(".reason")).to_contain_text([state.reason] if state.reason else [])
        assert page.evaluate("document.documentElement.scrollWidth") <= options["viewport"]["width"]
        screenshot(page, f"customer-{name}-{look}", whole=True)


@pytest.mark.parametrize(
    ("name", "tell", "heading"),
    [
        ("taken-back", taken_back, "This link was taken back"),
        *later(("expired", expired, "This link has expired")),
    ],
)
def test_a_link_that_has_ended_says_so_and_what_to_do(
    factory: OpenHouse, open_page: OpenPage, screenshot: Screenshot, name: str, tell: Tell, heading: str
) -> None:
    story = factory.do(tell)
    for look, options in LOOKS.items():
        page = open_at(factory, open_page, story, options)
        if look.endswith("en"):
            expect(page.get_by_role("heading", level=1)).to_have_text(heading)
            expect(page.get_by_text("Ask the sender for a new one.")).to_be_visible()
        screenshot(page, f"customer-{name}-{look}", whole=True)
