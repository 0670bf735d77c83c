"""A tablet tells in words of a door that does not open, and which vehicle stands before it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from msgspec.structs import replace
from open_house import OpenHouse, open_house
from playwright.sync_api import expect
from puppets import Puppet
from tablet_kit import LOOKS, Enter, card
from variants import variants

from dray.messages import AtvStatus, HelpWanted, ObstacleSeen, Problem, ProblemKind
from dray.plant import Door, LaneEnds, load_plant

from gateway_kit import House  # isort: skip - their folder is on the path since `puppets` is
from fake_bus import KEYS  # isort: skip

Screenshot = Callable[..., Path]

GATE = Door("GATE", "Hall gate", (LaneEnds("c2", "c3"),), 8.0)
PLANT = replace(load_plant("single-track").file, doors=(GATE,))


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, plant=PLANT) as house:
        yield house


async def stands_before_the_door(house: House) -> None:
    """A vehicle in the operator's area, which has told the others and asks for help."""
    vehicle = await Puppet.join(house, "ATV5", 27.0, 13.0, node="c2")
    seen = ObstacleSeen(atv="ATV5", start="c2", end="c3", there=True, forget_in_s=600.0)
    house.bus.join("ATV5", vehicle.on_message).publish(KEYS.obstacle("ATV5"), seen)
    about = Problem(kind=ProblemKind.WAY_BLOCKED, needs_person=True)
    reason = f"the door {GATE.name} does not open, and no way leads round it"
    vehicle.beat(status=AtvStatus.ERROR, problem=reason, about_problem=about, help=HelpWanted(until_s=4000.0))


@pytest.mark.parametrize("look", variants(LOOKS, "lying-light-en"))
def test_an_operator_reads_which_door_does_not_open(
    enter: Enter, house: OpenHouse, screenshot: Screenshot, look: str
) -> None:
    house.do(stands_before_the_door)
    page = enter(**LOOKS[look])
    expect(card(page, "ATV5")).to_contain_text("the door Hall gate does not open")
    screenshot(page, f"door-failed-tablet-{look}", whole=True)
