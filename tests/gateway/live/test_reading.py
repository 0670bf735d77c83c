"""docs/reading.md: what a gateway passes, and that what it names of the panels is there."""

from __future__ import annotations

import re

import pytest
from gateway_kit import House
from heartbeats import atv_heartbeat
from reading import FRONTEND, Passed, Walk, calls, sections
from stop_way import way

from dray.gateway.access.principal import ADMIN
from dray.messages import Event, OrderTaken
from dray.messages.fact import OrderFulfilled

pytestmark = pytest.mark.anyio

STRATEGIST = "strategist"


WALKED = (
    ("One order", "Somebody places it"),
    ("One order", "The customer is told"),
    ("One heartbeat", "A panel shows it"),
    ("One Stop", "It goes past the gateway"),
)


def test_every_part_of_the_gateway_is_walked_here() -> None:
    assert {
        (section, heading)
        for section, parts in sections().items()
        for heading, items in parts.items()
        if items[0][1].startswith("gateway/")
    } == set(WALKED)


def part(section: str, heading: str) -> list[Passed]:
    """What Python passes of it."""
    return [item for item in sections()[section][heading] if item[1].endswith(".py")]


def walk(section: str, heading: str, passed: list[Passed]) -> None:
    walk = Walk({heading: part(section, heading)})
    walk.step(passed)
    assert not walk.left, str(walk)


async def test_an_order_is_placed_and_its_end_is_told_as_it_is_to_be_read(house: House) -> None:
    with calls() as passed:
        order = await house.place()
    walk(*WALKED[0], passed)
    with calls() as passed:
        fulfilled = Event(
            agent=STRATEGIST, incarnation=1, number=1, at_s=1.0, fact=OrderFulfilled(order["id"])
        )
        house.bus.say(fulfilled)
        house.bus.tell(STRATEGIST, "gateway", OrderTaken(order["id"], fulfilled=True))
        await house.completions.written()
    walk(*WALKED[1], passed)
    assert (await house.get(f"/api/orders/{order['id']}"))["status"] == "delivered"


async def test_a_panel_is_told_of_a_heartbeat_as_it_is_to_be_read(house: House) -> None:
    assert house.hub.join(ADMIN) is not None
    with calls() as passed:
        house.bus.say(atv_heartbeat("ATV1"))
        house.hub.tick()
    walk(*WALKED[2], passed)


async def test_a_stop_passes_the_gateway_as_it_is_to_be_read(house: House) -> None:
    async with way(house) as stops:
        stops.vehicle()
        with calls() as passed:
            assert (await stops.ask()).status_code == 200
    walk(*WALKED[3], passed)


@pytest.mark.parametrize(
    ("name", "file"),
    [
        item
        for parts in sections().values()
        for items in parts.values()
        for item in items
        if not item[1].endswith(".py")
    ],
)
def test_what_it_names_of_the_panels_is_there(name: str, file: str) -> None:
    code = (FRONTEND / file).read_text(encoding="utf-8")
    assert re.search(rf"^export (async )?function {name}\b", code, re.MULTILINE)
