"""A load that was said to be there twice, in the manager's panel: the alert names its transport, whose page takes the word."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from held_load import TASK, MachineThatWaits
from manager_kit import GoingWall, as_manager
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, Route, expect

from dray.messages import MachineCommandKind

from gateway_kit import House  # isort: skip - its folder is on the path since `manager_kit` is

OpenPage = Callable[..., Page]


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


def test_the_alert_leads_to_the_page_which_says_that_the_load_is_missing(
    house: OpenHouse, open_page: OpenPage
) -> None:
    async def join(inside: House) -> MachineThatWaits:
        return MachineThatWaits(inside, 0.0)

    machine = house.do(join)
    page = as_manager(house, open_page)
    page.locator(".alerts-button").click()
    row = page.locator("main > section").first.get_by_role("row").filter(has_text="perhaps there")
    row.get_by_role("link", name=f"Show {TASK}").click()
    page.get_by_role("button", name="It is not there").click()
    expect(page.locator(".load-seen")).to_have_count(0)
    heard = house.until(lambda _: machine.heard)
    said = [(command.kind, command.task) for command in heard]
    assert said == [(MachineCommandKind.LOAD_MISSING, TASK)]


def test_the_alarm_names_the_dock_where_vehicles_fail_and_leads_to_the_page_which_takes_the_word(
    house: OpenHouse, open_page: OpenPage
) -> None:
    async def join(inside: House) -> MachineThatWaits:
        return MachineThatWaits(inside, 0.0, fails_at="M8")

    machine = house.do(join)
    page = as_manager(house, open_page)
    page.locator(".alerts-button").click()
    row = page.locator("main > section").first.get_by_role("row").filter(has_text="fail to load or unload")
    row.get_by_role("link", name=f"Show {TASK}").click()
    expect(page.locator(".load-seen")).to_contain_text("the dock of M8")
    page.get_by_role("button", name="It is in order").click()
    expect(page.locator(".load-seen")).to_have_count(0)
    heard = house.until(lambda _: machine.heard)
    assert [(command.kind, command.task) for command in heard] == [(MachineCommandKind.LOAD_MISSING, TASK)]


def test_a_press_that_began_before_the_panel_knew_anything_still_leads_to_the_alerts(
    house: OpenHouse, open_page: OpenPage
) -> None:
    """What stands in the bar does not move away under a finger, neither for a name nor for a count."""

    async def join(inside: House) -> MachineThatWaits:
        return MachineThatWaits(inside, 0.0)

    who: list[Route] = []

    def hold(route: Route) -> None:
        who.append(route)

    page = as_manager(house, open_page, before=lambda page: page.route("**/api/me", hold))
    alerts, person = page.locator(".alerts-button"), page.locator("button.person")
    alerts.hover()
    page.mouse.down()
    box = person.bounding_box()
    house.do(join)
    expect(alerts).to_have_text("1 warning")
    who.pop().continue_()
    expect(person).to_have_text("Manager")
    page.mouse.up()
    expect(alerts).to_have_attribute("aria-current", "page")
    assert person.bounding_box() == box
