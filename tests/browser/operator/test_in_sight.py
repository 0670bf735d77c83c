"""What a hand and an eye need on the tablet and the phone is in sight, wherever somebody has scrolled."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from calling_kit import SOON_S, asks, vehicle_calls
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from puppets import Puppet
from tablet_kit import IN_AREA, LYING, PHONE, STATION, UPRIGHT, Enter, card, stop_of
from variants import variants

from dray.messages import HelpWanted, MachineStatus, Problem, ProblemKind

from gateway_kit import House  # isort: skip - its folder is on the path since `puppets` is
from heartbeats import machine_heartbeat  # isort: skip - likewise

Screenshot = Callable[..., Path]

PARTS = 3
"""The station, the map and the line of duty, beside the vehicles."""

TO_THE_END = (
    """() => document.querySelectorAll("main, html").forEach(each => each.scrollTo(0, each.scrollHeight))"""
)

CARDS = """() => [...document.querySelectorAll(".station, .vehicle, .duty, .place .map")]
    .filter(each => each.checkVisibility())
    .map(each => each.getBoundingClientRect())
    .map(({left, right}) => [Math.round(left), Math.round(right)])"""
"""Left and right of each card."""

OF_ITS_OWN = (".duty", ".place .map canvas", ".station .stock li")
"""What is shown once an answer of its own is there, which may come after the vehicles."""

CUT = """all => all.filter(each => each.scrollWidth > each.clientWidth).map(each => each.textContent)"""

TONES = """
    window.tones = 0;
    const start = OscillatorNode.prototype.start;
    OscillatorNode.prototype.start = function (...at) {
        document.documentElement.dataset.tones = ++window.tones;
        return start.apply(this, at);
    };
"""
"""Counts the tones that a page plays."""

LINE_PX = 96.0
"""A button for a finger in a glove, and what is around it."""


SIZES = {"1024x768": LYING, "1280x800": {"width": 1280, "height": 800}, "800x1280": UPRIGHT}

LOCALES = {"de": "de-DE", "en": "en-GB", "es": "es-ES"}

INSET_PX = 9
"""So far from its edges a button with round corners is hit for certain."""

TOP = "each => each.getBoundingClientRect().top"

MISSED = """inset => [...document.querySelectorAll("main button, main summary")].filter(each => {
    if (!each.checkVisibility()) return false;
    each.scrollIntoView({ block: "nearest", inline: "nearest" });
    const { bottom, left, right, top } = each.getBoundingClientRect();
    const points = [left + inset, right - inset].flatMap(x => [top + inset, bottom - inset].map(y => [x, y]));
    return points.some(([x, y]) => !each.contains(document.elementFromPoint(x, y)));
}).map(each => `${each.closest("[id]")?.id}: ${each.textContent}`)"""
"""Whatever can be touched on the page and is covered by something at one of its corners, once it was scrolled to."""


def all_there(page: Page) -> None:
    """Wait until each card stands that this page has: what is measured afterwards is measured at once."""
    expect(page.locator(".vehicle")).to_have_count(len(IN_AREA))
    for part in OF_ITS_OWN:
        expect(page.locator(part).first).to_be_visible()


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    """A gateway at which people can be on duty."""
    with open_house(sqlite_url, duty=True) as house:
        yield house


def test_on_a_phone_stop_stays_in_sight_and_all_else_is_one_column(
    vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    page = enter(viewport=PHONE)
    all_there(page)
    # The place counts more than that: the line of duty is on the page.
    expect(page.locator(".top-duty")).to_be_hidden()
    material = page.locator(".station .stock li > :first-child")
    expect(material).to_have_text(["Housing", "Shaft"])
    assert material.evaluate_all(CUT) == []
    edges = page.evaluate(CARDS)
    assert len(edges) == PARTS + len(IN_AREA)
    assert len({tuple(each) for each in edges}) == 1, edges
    assert 0 <= edges[0][0] < edges[0][1] <= PHONE["width"]
    screenshot(page, "in-sight-phone")
    for move in ("() => {}", TO_THE_END):
        page.evaluate(move)
        for vehicle in vehicles:
            expect(stop_of(page, vehicle)).to_be_in_viewport(ratio=1)


def test_on_a_tablet_vehicles_and_material_stand_above_the_fold_and_duty_is_a_line(
    vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    page = enter(viewport=LYING)
    all_there(page)
    for vehicle in vehicles:
        expect(card(page, vehicle).get_by_role("heading")).to_be_in_viewport(ratio=1)
        expect(card(page, vehicle).locator(".steps button").last).to_be_in_viewport(ratio=1)
    rows = page.locator(".station .stock li").all()
    assert len(rows) >= 2
    for row in rows:
        expect(row).to_be_in_viewport(ratio=1)
    duty = page.locator(".duty").bounding_box()
    assert duty is not None
    assert duty["height"] <= LINE_PX
    screenshot(page, "in-sight-tablet")


def test_on_a_tablet_that_lies_the_state_of_duty_says_of_what_it_is_and_leads_to_all_of_its_line(
    vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter(viewport=LYING)
    all_there(page)
    state = page.locator(".top-duty")
    expect(state).to_contain_text("My duty")
    expect(state).to_contain_text("Off duty")
    state.tap()
    expect(page.locator(".duty")).to_be_in_viewport(ratio=1)


@pytest.mark.parametrize("size", [LYING, UPRIGHT, PHONE], ids=["lying", "upright", "phone"])
def test_a_call_stays_in_sight_is_heard_and_named_by_the_tab(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    size: dict[str, int],
    request: pytest.FixtureRequest,
) -> None:
    calling = vehicle_calls(house, vehicles["ATV2"])
    page: Page = enter(viewport=size, before=lambda page: page.add_init_script(TONES))
    all_there(page)
    on = page.locator(".duty-choices button").first
    on.tap()
    expect(on).to_have_attribute("aria-pressed", "true")
    sound = page.get_by_role("group", name="A sound when somebody calls you?")
    sound.get_by_role("button", name="With sound").tap()
    expect(page.locator("html")).to_have_attribute("data-tones", "2")
    # Asked for once.
    expect(sound).to_have_count(0)
    page.evaluate(TO_THE_END)
    asks(house, calling)
    call = page.locator(".call")
    expect(call.get_by_role("heading")).to_be_in_viewport(ratio=1)
    expect(call.locator(".call-left")).to_be_in_viewport(ratio=1)
    for answer in ("I take it within 5 min", "Pass"):
        expect(call.get_by_role("button", name=answer)).to_be_in_viewport(ratio=1)
    for vehicle in vehicles:
        expect(stop_of(page, vehicle)).to_be_in_viewport(ratio=1)
    # Two more at once, and two each few seconds for as long as nobody answers.
    expect(page.locator("html")).to_have_attribute("data-tones", re.compile(r"^([4-9]|\d\d+)$"))
    expect(page).to_have_title(re.compile("^ATV2 asks you "))
    screenshot(page, f"in-sight-call-{request.node.callspec.id}")


@pytest.mark.parametrize("language", LOCALES)
@pytest.mark.parametrize("size", variants(SIZES, "1024x768", "800x1280"))
def test_a_call_covers_nothing_that_can_be_touched(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    size: str,
    language: str,
) -> None:
    async def break_down(inside: House) -> None:
        about = Problem(kind=ProblemKind.JAM, needs_person=True)
        wanted = HelpWanted(until_s=SOON_S)
        broken = {"status": MachineStatus.ERROR, "problem": "a part is stuck", "about_problem": about}
        inside.bus.say(machine_heartbeat(STATION, 2, at_s=3601.0, help=wanted, **broken))

    calling = [vehicle_calls(house, vehicles[atv]) for atv in ("ATV2", "ATV6")]
    page = enter(viewport=SIZES[size], locale=LOCALES[language])
    all_there(page)
    house.do(break_down)
    expect(page.locator(f"#machine-{STATION} .steps")).to_be_visible()
    on = page.locator(".duty-choices button").first
    on.tap()
    expect(on).to_have_attribute("aria-pressed", "true")
    page.evaluate(TO_THE_END)
    before = on.evaluate(TOP)
    asks(house, calling[0])
    answers = page.locator(".call-answers button")
    expect(answers.last).to_be_enabled()
    # Nobody's finger meets something else.
    assert abs(on.evaluate(TOP) - before) < 1.0
    for answer in answers.all():
        expect(answer).to_be_in_viewport(ratio=1)
    screenshot(page, f"call-covers-nothing-{size}-{language}")
    assert page.evaluate(MISSED, INSET_PX) == []
    asks(house, calling[1])
    expect(page.locator(".call")).to_have_count(2)
    assert page.evaluate(MISSED, INSET_PX) == []
    screenshot(page, f"two-calls-cover-nothing-{size}-{language}")
