"""A load of which nobody can tell, on the tablet of its area: people are asked to count, and a long touch says what is there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from doubtful_load import DOUBT, MachineInDoubt
from gateway_kit import House
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
def test_whoever_has_counted_says_by_a_long_touch_what_is_there(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    look: str,
    there: bool,
) -> None:
    async def join(inside: House) -> MachineInDoubt:
        return MachineInDoubt(inside, LATER_S)

    machine = house.do(join)
    page = enter(**LOOKS[look])
    card = page.locator(f"[id='doubt-{DOUBT.load}']")
    for said in (STATION, str(DOUBT.quantity), DOUBT.vehicle):
        expect(card).to_contain_text(said)
    # Its title says the place, and nothing says it again beside it.
    expect(card.locator("header .tag")).to_have_count(0)
    screenshot(page, f"doubtful-load-{look}")
    answer(page, card, first=there)
    kind = MachineCommandKind.LOAD_THERE if there else MachineCommandKind.LOAD_MISSING
    assert [(command.kind, command.task) for command in machine.heard] == [(kind, DOUBT.load)]
