"""A load of which nobody can tell, in the manager's panel: the alert names it and leads to its machine, whose card takes the answer."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from doubtful_load import DOUBT, MachineInDoubt
from manager_kit import GoingWall, as_manager
from obedient_machine import STATION
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect

from dray.messages import MachineCommandKind

from gateway_kit import House  # isort: skip - its folder is on the path since `manager_kit` is

OpenPage = Callable[..., Page]


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


def test_the_alert_leads_to_the_machine_whose_card_takes_what_was_counted(
    house: OpenHouse, open_page: OpenPage, screenshot: Callable[..., Path]
) -> None:
    async def join(inside: House) -> MachineInDoubt:
        return MachineInDoubt(inside, 0.0)

    machine = house.do(join)
    page = as_manager(house, open_page)
    page.locator(".alerts-button").click()
    row = page.locator("main > section").first.get_by_role("row").filter(has_text="perhaps lie there")
    expect(row).to_contain_text(str(DOUBT.quantity))
    row.get_by_role("button", name=f"Show {STATION}").click()
    asked = page.locator(".card.machine .load-seen")
    expect(asked).to_contain_text(f"whether {DOUBT.vehicle} took them")
    screenshot(page, "doubtful-load-card")
    asked.get_by_role("button", name="It is there").click()
    expect(asked).to_have_count(0)
    expect(page.get_by_text("perhaps lie there")).to_have_count(0)
    heard = house.until(lambda _: machine.heard)
    assert [(command.kind, command.task) for command in heard] == [
        (MachineCommandKind.LOAD_THERE, DOUBT.load)
    ]
