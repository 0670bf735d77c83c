"""What asks for an answer and what lies in the way are both on the plant's page, and neither covers the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from looks import CUT, LOCALES
from manager_kit import GoingWall, as_manager
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from puppets import Puppet

from dray.messages import MachineStatus, ObstacleSeen
from dray.plant import load_plant

from gateway_kit import House  # isort: skip - its folder is on the path since `puppets` is
from fake_bus import KEYS  # isort: skip
from heartbeats import machine_heartbeat  # isort: skip
from wall_clock import NOW_S  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PLANT = load_plant("single-track")
LANES = (("c2", "c3"), ("a1", "a2"))

SHOWN = """(part) => {
    const { bottom, left, top, width } = part.getBoundingClientRect();
    return [top + 2, (top + bottom) / 2, bottom - 2].every(y => part.contains(document.elementFromPoint(left + width / 2, y)));
}"""
"""Whether the upper edge, the middle and the lower edge of something are what is seen there."""


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    """Three machines have failed, and a vehicle has met something on two lanes."""

    async def trouble(inside: House) -> None:
        at_s = inside.wall() - NOW_S
        for machine in ("M3", "M5", "M8"):
            beat = machine_heartbeat(machine, 1, at_s=at_s, status=MachineStatus.ERROR, problem="spindle")
            inside.bus.say(beat)
        spot = PLANT.nodes["c2"]
        vehicle = await Puppet.join(inside, "ATV5", spot.x_m, spot.y_m, node="c2", at_s=at_s)
        for start, end in LANES:
            seen = ObstacleSeen(atv="ATV5", start=start, end=end, there=True, forget_in_s=600.0)
            inside.bus.join("ATV5", vehicle.on_message).publish(KEYS.obstacle("ATV5"), seen)

    with open_house(sqlite_url, wall=GoingWall()) as house:
        house.do(trouble)
        yield house


def test_an_alarm_covers_nothing_of_what_lies_in_the_way(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = as_manager(house, open_page, viewport={"width": 1920, "height": 1080})
    inbox, lanes = page.locator(".inbox"), page.locator(".closures")
    expect(inbox.get_by_role("listitem").first).to_be_visible()
    expect(lanes.get_by_role("listitem")).to_have_count(len(LANES))
    assert lanes.evaluate(SHOWN)
    assert inbox.evaluate(SHOWN)
    assert page.locator(".publish").evaluate(SHOWN)
    expect(lanes.get_by_role("button").first).to_be_in_viewport(ratio=1)
    assert page.locator(".factory").evaluate(CUT) == []
    screenshot(page, "alarms-and-obstacles")
    # On a low screen, too, what is scrolled to is not under the alarms.
    page.set_viewport_size({"width": 1440, "height": 900})
    button = lanes.get_by_role("button").last
    button.focus()
    button.scroll_into_view_if_needed()
    assert button.evaluate(SHOWN)
    screenshot(page, "alarms-and-obstacles-low")


PLACES = """() => [...document.querySelectorAll(".publish :is(button, input, select), .inbox :is(button, a):not(.inbox-closed)")].map(each => {
    const { left, top } = each.getBoundingClientRect();
    return [each.textContent, left, top];
})"""
"""Where everything that a hand may be on its way to is."""


@pytest.mark.parametrize("language", LOCALES)
def test_on_a_low_screen_the_alarms_say_that_something_is_closed_and_lead_to_it(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot, language: str
) -> None:
    page = as_manager(house, open_page, viewport={"width": 1280, "height": 800}, locale=LOCALES[language])
    inbox = page.locator(".inbox")
    expect(inbox.get_by_role("listitem")).to_have_count(3)
    expect(page.locator(".closures")).to_have_count(1)
    # What the gateway foresees of the order, which makes the form higher.
    expect(page.locator(".publish .feasible p .tone-warn")).to_be_visible()
    before = page.evaluate(PLACES)

    async def close(inside: House) -> None:
        lane = {"kind": "slow", "lane": {"start": "c3", "end": "m5-lane"}, "speed_mps": 0.5}
        answer = await inside.client.post("/api/closures", json=lane | {"reason": "oil on the floor"})
        assert answer.status_code == 201, answer.text

    house.do(close)
    way = inbox.locator(".inbox-closed")
    expect(way).to_contain_text("1")
    expect(page.locator(".closures")).to_have_count(2)
    assert page.evaluate(PLACES) == before
    assert way.evaluate(SHOWN)
    assert page.locator(".inbox .card-head").evaluate("head => head.scrollWidth <= head.clientWidth")
    screenshot(page, f"alarms-and-closures-{language}")
    way.click()
    first = page.locator(".closures button").first
    expect(first).to_be_focused()
    assert first.evaluate(SHOWN)
    assert page.evaluate(PLACES) == before
    screenshot(page, f"alarms-and-closures-shown-{language}")
    page.set_viewport_size({"width": 1920, "height": 1080})
    expect(way).to_be_hidden()
