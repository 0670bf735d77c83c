"""Goods on board of a vehicle that has failed, in the manager's alerts: what, for which order, until when, and the way to the card."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from goods_aboard import REFERENCE, TASK, MachineWithGoods
from looks import LOCALES, in_every_look
from manager_kit import GoingWall, as_manager
from open_house import OpenHouse, open_house
from playwright.sync_api import Locator, Page, expect
from tablet_kit import press_and_hold

from gateway_kit import House  # isort: skip - its folder is on the path since `manager_kit` is

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


@pytest.fixture
def machine(house: OpenHouse) -> MachineWithGoods:
    async def join(inside: House) -> MachineWithGoods:
        return MachineWithGoods(inside, 0.0)

    return house.do(join)


def row_of(page: Page) -> Locator:
    page.locator(".alerts-button").click()
    return page.locator("main > section").first.get_by_role("row").filter(has_text=REFERENCE)


def test_the_alert_tells_which_goods_for_which_order_and_leads_to_the_card(
    house: OpenHouse, machine: MachineWithGoods, open_page: OpenPage
) -> None:
    page = as_manager(house, open_page)
    row = row_of(page)
    expect(row).to_contain_text("ATV2")
    expect(row).to_contain_text("24")
    expect(row).to_contain_text("made again")
    row.get_by_role("link", name="To the operator's card").click()
    card = page.locator(f"#goods-{TASK}")
    expect(card).to_contain_text(REFERENCE)
    expect(card).to_be_in_viewport()
    press_and_hold(page, card.locator(".vehicle-acts button").last)
    expect(card).to_have_count(0)
    assert [command.task for command in machine.heard] == [TASK]
    house.until(
        lambda inside: all(each.kind != "goods_stranded" for each in inside.projection.alerts.views())
    )


@in_every_look
def test_the_alert_in_every_look(
    house: OpenHouse,
    machine: MachineWithGoods,
    open_page: OpenPage,
    screenshot: Screenshot,
    language: str,
    theme: str,
) -> None:
    page = as_manager(house, open_page, locale=LOCALES[language], color_scheme=theme)
    expect(row_of(page)).to_be_visible()
    screenshot(page, f"goods-alert-{language}-{theme}")
    page.goto(f"{house.url}/operator#goods-{TASK}")
    expect(page.locator(f"#goods-{TASK}")).to_be_in_viewport()
    screenshot(page, f"goods-card-{language}-{theme}")
