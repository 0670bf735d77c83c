"""A machine that no plant file knows appears on the map of a panel that is open already."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from open_house import open_house
from playwright.sync_api import Page, expect

sys.path.insert(0, str(Path(__file__).parents[2] / "gateway/kits"))

from gateway_kit import House
from joining_kit import BEFORE, SPEC, introduction

from dray.gateway.access.principal import Role


async def _manager(house: House) -> str:
    return (await house.log_in("manager", Role.MANAGER)).cookies["dray_session"]


async def _join(house: House) -> None:
    house.bus.say(introduction())


@pytest.mark.slow
def test_a_joining_agent_appears_on_the_map_of_an_open_panel(
    open_page: Callable[..., Page], screenshot: Callable[..., Path], sqlite_url: str
) -> None:
    with open_house(sqlite_url, plant=BEFORE) as house:
        page = open_page("about:blank", who=None)
        cookie = {"name": "dray_session", "value": house.do(_manager), "url": house.url}
        page.context.add_cookies([cookie | {"httpOnly": True, "sameSite": "Strict"}])
        page.goto(house.url)
        finder = page.get_by_role("combobox", name="Find")
        found = page.get_by_role("option").filter(has_text=SPEC.name)
        finder.fill(SPEC.name)
        expect(page.get_by_text("Nothing of that name")).to_be_visible()
        screenshot(page, "nothing-found")
        # Who is still looking need not type again.
        house.do(_join)
        expect(found).to_have_count(1)
        finder.press("Enter")
        expect(page.get_by_role("heading", name=SPEC.name)).to_be_visible()
        screenshot(page, "joining")
