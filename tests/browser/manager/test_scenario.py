"""The card of a scenario: a manager reads what has happened, what is next and how it ended."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from looks import LOCALES
from manager_kit import GoingWall, as_manager
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect

from dray.gateway.live.views import ScenarioCheckView, ScenarioView, StepView
from dray.messages import MachineStatus
from dray.scenario_steps import ScenarioStep

from fake_player import FakePlayer  # isort: skip - as below
from gateway_kit import House  # isort: skip - its folder is on the path since `open_house` is
from heartbeats import machine_heartbeat  # isort: skip
from wall_clock import NOW_S  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

CHECKS = (ScenarioCheckView(name="ATV1 delivers", held=False, figure="not delivered"),)


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


def put(house: OpenHouse, **more: object) -> None:
    """ATV3 is switched off; its task is not taken over yet."""
    steps = (
        StepView(step=ScenarioStep.SWITCHED_OFF, after_s=605.0, agents=("ATV3",)),
        StepView(step=ScenarioStep.TAKEN_OVER),
        StepView(step=ScenarioStep.DELIVERED),
    )
    view = ScenarioView(id="experiment-power-off", shows="Figure 6, right", steps=steps, **more)  # type: ignore[arg-type]

    async def tell(inside: House) -> None:
        inside.projection.scenarios.put(view)

    house.do(tell)


def test_steps_are_told_as_they_happen_and_then_the_end(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = as_manager(house, open_page)
    card = page.locator(".scenario")
    expect(page.get_by_role("heading", name="Factory")).to_be_visible()
    expect(card).to_have_count(0)
    put(house)
    lines = card.locator("ol").get_by_role("listitem")
    expect(lines).to_have_text(
        [
            "Switched off: ATV310:05 min",
            "The task is taken overnext",
            "Delivered",
        ]
    )
    expect(lines.nth(1)).to_have_attribute("aria-current", "step")
    screenshot(page, "scenario")
    put(house, state="failed", after_s=2400.0, checks=CHECKS)
    expect(card.get_by_role("status")).to_have_text("Did not hold, after 40:00 min")
    expect(lines.nth(2)).to_contain_text("did not happen")
    card.locator("summary").click()
    expect(card.get_by_text("ATV1 delivers")).to_be_visible()


def test_a_manager_sees_when_the_next_step_comes_and_skips_to_it(
    sqlite_url: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    player = FakePlayer()
    with open_house(sqlite_url, wall=GoingWall(), scenario=player) as house:
        page = as_manager(house, open_page)
        card = page.locator(".scenario")
        expect(card.get_by_role("listitem").nth(1)).to_contain_text(re.compile(r"next, in \d+:\d\d\smin$"))
        screenshot(page, "scenario-countdown")
        page.set_viewport_size({"width": 1440, "height": 900})
        orders, around = page.locator(".orders").bounding_box(), page.locator(".giving").bounding_box()
        assert orders is not None
        assert around is not None
        assert orders["height"] >= 139
        assert orders["y"] + orders["height"] <= around["y"] + around["height"] + 1
        expect(card.locator("[aria-current]")).to_be_in_viewport(ratio=1.0)
        card.get_by_role("button", name="Skip to the next step").click()
        stop = card.get_by_role("button", name="Stop skipping")
        expect(stop).to_be_visible()
        assert player.view.skipping
        stop.click()
        expect(card.get_by_role("button", name="Skip to the next step")).to_be_visible()
        assert not player.view.skipping

        async def come(_inside: House) -> None:
            steps = (
                player.view.steps[0],
                StepView(step=ScenarioStep.CONTRACTED, after_s=601.0, agents=("M8",)),
            )
            player.put(state="held", after_s=601.0, steps=steps)

        house.do(come)
        expect(card.get_by_role("status")).to_have_text("Held, after 10:01 min")
        expect(card.get_by_role("button", name="Skip to the next step")).to_have_count(0)


COVERED = """() => [...document.querySelectorAll(".left :is(a, button)")].filter(each => {
  if (!each.checkVisibility()) return false;
  const {bottom, left, top, width} = each.getBoundingClientRect();
  const clips = [each.closest(".card-body"), each.closest(".inbox-list"), each.closest(".giving"), document.documentElement];
  const inSight = y => clips.every(clip => {
    if (clip === null) return true;
    const around = clip.getBoundingClientRect();
    return y > around.top && y < around.bottom;
  });
  return [top + 2, (top + bottom) / 2, bottom - 2].some(y => inSight(y) && !each.contains(document.elementFromPoint(left + width / 2, y)));
}).map(each => each.textContent)"""
"""What can be touched, is not scrolled out of sight, and lies below something else."""

SIDEWAYS = "list => [...list.querySelectorAll('p, small')].filter(each => each.scrollWidth > each.clientWidth).length"


@pytest.mark.parametrize("language", LOCALES)
def test_on_a_small_laptop_an_alarm_covers_nothing_beside_a_scenario(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot, language: str
) -> None:
    async def fail(inside: House) -> None:
        at_s = inside.wall() - NOW_S
        beat = machine_heartbeat("M8", 1, at_s=at_s, status=MachineStatus.ERROR, problem="spindle")
        inside.bus.say(beat)

    put(house)
    page = as_manager(house, open_page, viewport={"width": 1280, "height": 800}, locale=LOCALES[language])
    expect(page.locator(".scenario")).to_be_visible()
    house.do(fail)
    inbox = page.locator(".inbox")
    expect(inbox.get_by_role("button").last).to_be_in_viewport(ratio=1)
    orders = page.locator(".orders a").first
    giving = page.locator(".giving")
    for height_px in (800, 768, 720):
        page.set_viewport_size({"width": 1280, "height": height_px})
        giving.evaluate("each => each.scrollTo(0, 0)")
        assert page.evaluate(COVERED) == [], height_px
        giving.evaluate("each => each.scrollTo(0, each.scrollHeight)")
        assert page.evaluate(COVERED) == [], height_px
        orders.scroll_into_view_if_needed()
        expect(orders).to_be_in_viewport(ratio=1)
        assert page.evaluate(COVERED) == [], height_px
        assert inbox.evaluate(SIDEWAYS) == 0, height_px
    screenshot(page, f"scenario-alarm-{language}")


@pytest.mark.slow
def test_the_map_is_as_in_the_paper_for_who_wants_it_so(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = as_manager(house, open_page, color_scheme="dark")
    plant_map = page.locator("#plant-map")
    expect(plant_map).to_be_visible()
    calm = plant_map.screenshot()
    page.locator("button.person").click()
    choice = page.get_by_role("button", name="As in the paper (light)")
    choice.click()
    expect(choice).to_have_attribute("aria-pressed", "true")
    assert plant_map.screenshot() != calm
    page.reload()
    expect(plant_map).to_be_visible()
    expect(page.locator("html")).to_have_attribute("data-theme", "paper")
    screenshot(page, "as-in-the-paper")
