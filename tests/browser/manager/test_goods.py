"""A machine's card tells of finished pieces that no order wants any more, as a cancelled order leaves them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from variants import later

sys.path.insert(0, str(Path(__file__).parents[2] / "gateway/kits"))

from gateway_kit import House
from heartbeats import machine_heartbeat

from dray.gateway.access.principal import Role
from dray.messages import BufferLevel


async def _manager(house: House) -> str:
    return (await house.log_in("manager", Role.MANAGER)).cookies["dray_session"]


async def _make(house: House) -> None:
    goods = (BufferLevel(item="P1", level=7, capacity=40, spare=3),)
    house.bus.say(machine_heartbeat("M1", at_s=3600.0, goods=goods))


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url) as house:
        yield house


@pytest.mark.parametrize(
    ("language", "find", "said"),
    [
        ("en-GB", "Find", "3 that no order wants; the next goal takes them"),
        *later(("de-DE", "Suchen", "3, die kein Auftrag braucht; der nächste Fertigungsauftrag nimmt sie")),
    ],
)
def test_pieces_that_no_order_wants_are_told_at_their_machine(
    house: OpenHouse,
    open_page: Callable[..., Page],
    screenshot: Callable[..., Path],
    language: str,
    find: str,
    said: str,
) -> None:
    house.do(_make)
    page = open_page("about:blank", who=None, locale=language)
    cookie = {"name": "dray_session", "value": house.do(_manager), "url": house.url}
    page.context.add_cookies([cookie | {"httpOnly": True, "sameSite": "Strict"}])
    page.goto(house.url)
    finder = page.get_by_role("combobox", name=find, exact=True)
    finder.fill("M1")
    expect(page.locator("#finder-list").get_by_role("option").first).to_be_visible()
    finder.press("Enter")
    expect(page.locator(".card.machine .stock-row").filter(has_text=said)).to_have_count(1)
    screenshot(page, f"spare-goods-{language}")
