"""A load that was said to be there twice, and a dock where vehicles fail, on the tablet of its area.

Whoever has looked says what is there, by a long touch.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from gateway_kit import House
from held_load import TASK, MachineThatWaits
from obedient_machine import STATION
from open_house import OpenHouse
from playwright.sync_api import expect
from puppets import LATER_S, Puppet
from tablet_kit import LOOKS, Enter, answer
from variants import variants

from dray.messages import MachineCommandKind

Screenshot = Callable[..., Path]


@pytest.mark.parametrize("look", variants(LOOKS, "upright-dark-de"))
@pytest.mark.parametrize("there", [True, False])
def test_whoever_has_looked_says_by_a_long_touch_what_is_there(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    look: str,
    there: bool,
) -> None:
    async def join(inside: House) -> MachineThatWaits:
        return MachineThatWaits(inside, LATER_S)

    machine = house.do(join)
    page = enter(**LOOKS[look])
    card = page.locator(f"#held-{TASK}")
    expect(card).to_contain_text(STATION)
    expect(card).to_contain_text("24")
    screenshot(page, f"held-load-{look}")
    answer(page, card, first=there)
    kind = MachineCommandKind.LOAD_THERE if there else MachineCommandKind.LOAD_MISSING
    assert [(command.kind, command.task) for command in machine.heard] == [(kind, TASK)]


DOCK = {"lying-light-en": "the dock", "upright-dark-de": "Dock", "phone-dark-es": "muelle"}
"""By look, what a dock is called."""


@pytest.mark.parametrize("look", variants(LOOKS, "upright-dark-de"))
@pytest.mark.parametrize("in_order", [True, False])
def test_whoever_has_looked_at_a_dock_where_vehicles_fail_says_so_by_a_long_touch(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    look: str,
    in_order: bool,
) -> None:
    async def join(inside: House) -> MachineThatWaits:
        return MachineThatWaits(inside, LATER_S, fails_at=STATION)

    machine = house.do(join)
    page = enter(**LOOKS[look])
    card = page.locator(f"#held-{TASK}")
    expect(card).to_contain_text(DOCK[look])
    expect(card).to_contain_text(STATION)
    screenshot(page, f"failing-dock-{look}")
    answer(page, card, first=in_order)
    kind = MachineCommandKind.LOAD_MISSING if in_order else MachineCommandKind.LOAD_THERE
    assert [(command.kind, command.task) for command in machine.heard] == [(kind, TASK)]
