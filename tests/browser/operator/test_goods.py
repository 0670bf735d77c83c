"""Goods on board of a dead vehicle, on the tablet of its area: who is on duty is called to them, hands them over, or writes them off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from gateway_kit import House
from goods_aboard import NODE, REFERENCE, TASK, MachineWithGoods
from open_house import OpenHouse
from playwright.sync_api import expect
from puppets import LATER_S, Puppet
from tablet_kit import LOOKS, Enter, assert_touchable, press_and_hold
from variants import variants

from dray.messages import MachineCommandKind

Screenshot = Callable[..., Path]


@pytest.mark.parametrize("look", variants(LOOKS, "upright-dark-de"))
def test_goods_of_a_dead_vehicle_are_handed_over_in_one_touch_and_written_off_by_a_long_one(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    async def join(inside: House) -> MachineWithGoods:
        return MachineWithGoods(inside, LATER_S)

    machine = house.do(join)
    page = enter(**LOOKS[look])
    card = page.locator(f"#goods-{TASK}")
    expect(card).to_contain_text("ATV2")
    expect(card).to_contain_text("c2")
    expect(card).to_contain_text("24")
    expect(card).to_contain_text(REFERENCE)
    buttons = card.locator(".vehicle-acts button")
    expect(buttons).to_have_count(2)
    assert_touchable(*buttons.all())
    screenshot(page, f"goods-{look}")

    buttons.first.tap()
    expect(buttons).to_have_count(1)
    expect(card).to_contain_text(NODE)
    expect(card.locator(".command-confirmed")).to_have_count(1)
    screenshot(page, f"goods-fetched-{look}")

    # Writing them off has come to where the finger is: whoever touches twice must not do that.
    buttons.first.tap()
    expect(card.locator(".command")).to_have_count(1)
    press_and_hold(page, buttons.first)
    expect(card).to_have_count(0)
    said = [(command.kind, command.task, command.node) for command in machine.heard]
    kinds = MachineCommandKind.FETCH_GOODS, MachineCommandKind.WRITE_OFF
    assert said == [(kind, TASK, "") for kind in kinds]
