"""An operator goes on duty, is asked by a vehicle whose way is blocked, takes the call, comes, and is free again (paper, case 4)."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from calling_kit import BLOCKED, SOON_S, Calling, asks, do, on_duty, vehicle_calls
from frames import LOOK_MS
from gateway_kit import House
from goods_aboard import REFERENCE, TASK, MachineWithGoods
from manager_kit import as_manager
from obedient_machine import STATION
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, Route, expect
from puppets import LATER_S, Puppet
from tablet_kit import LOOKS as SHAPES
from tablet_kit import LYING, UPRIGHT, Enter, assert_touchable, beat, card, settle
from variants import variants

from dray.messages import (
    AtvStatus,
    CallAnswer,
    CallPlace,
    CallState,
    CommandKind,
    DutyStatus,
    HelpWanted,
    Problem,
    ProblemKind,
)

Screenshot = Callable[..., Path]
OpenPage = Callable[..., Page]

MOST_LINES = """all => Math.max(...all.map((each) => {
    const words = document.createRange();
    words.selectNodeContents(each);
    return new Set([...words.getClientRects()].map((line) => Math.round(line.top))).size;
}))"""
"""Lines of the longest label."""

LOOKS: dict[str, tuple[dict[str, Any], dict[str, str]]] = {
    "en": (
        {"viewport": LYING, "color_scheme": "light", "locale": "en-GB"},
        {
            "on": "On duty",
            "asks": "asks you",
            "take": "I take it within 5 min",
            "expects": "expects you",
            "off": "Off duty",
        },
    ),
    "de": (
        {"viewport": UPRIGHT, "color_scheme": "dark", "locale": "de-DE"},
        {
            "on": "Im Dienst",
            "asks": "fragt Sie",
            "take": "Ich übernehme in 5 min",
            "expects": "erwartet Sie",
            "off": "Nicht im Dienst",
        },
    ),
    "es": (
        {"viewport": LYING, "color_scheme": "light", "locale": "es-ES"},
        {
            "on": "De guardia",
            "asks": "le pregunta",
            "take": "Voy yo en 5 min",
            "expects": "le espera",
            "off": "Fuera de guardia",
        },
    ),
}


LINES = """all => all.map(each => {
    const texts = document.createTreeWalker(each, NodeFilter.SHOW_TEXT);
    const tops = new Set();
    while (texts.nextNode()) {
        const words = document.createRange();
        words.selectNode(texts.currentNode);
        for (const {top, width} of words.getClientRects()) if (width > 1) tops.add(Math.round(top / 4));
    }
    return tops.size;
})"""
"""How many lines the words of each button take."""


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    """A gateway at which people can be on duty."""
    with open_house(sqlite_url, duty=True) as house:
        yield house


@pytest.mark.parametrize("language", variants(["de", "en", "es"]))
def test_an_operator_on_duty_is_asked_takes_a_blocked_way_and_is_free_again(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, language: str
) -> None:
    look, says = LOOKS[language]
    vehicle = vehicles["ATV2"]
    calling = vehicle_calls(house, vehicle)
    page: Page = enter(**look)
    page.get_by_role("button", name=says["on"], exact=True).tap()
    expect(page.get_by_role("button", name=says["on"], exact=True)).to_have_attribute("aria-pressed", "true")

    [operator] = house.until(on_duty)
    waits = HelpWanted(until_s=SOON_S)
    house.do(
        beat(
            vehicle, status=AtvStatus.ERROR, problem="a pallet on the lane", about_problem=BLOCKED, help=waits
        )
    )
    do(house, lambda _inside: calling.say(state=CallState.ASKING, asked=(operator,), until_s=SOON_S))
    call = page.locator(".call")
    expect(call).to_contain_text(says["asks"])
    expect(call).to_contain_text("ATV2")
    assert_touchable(*call.get_by_role("button").all())
    # One row of answers for a call, and not a second one on the vehicle's card.
    expect(page.locator(".call-answers")).to_have_count(1)
    expect(card(page, "ATV2").locator(".promises")).to_have_count(0)
    assert max(call.locator(".call-answers button").evaluate_all(LINES)) <= 2
    screenshot(page, f"duty-asked-{language}")
    call.get_by_role("button", name=says["take"]).tap()
    expect(call).to_contain_text(says["expects"])
    # The page may have asked anew before the vehicle was told.
    house.until(lambda _inside: vehicle.heard)
    assert calling.answers == [CallAnswer.TAKE]
    assert [command.kind for command in vehicle.heard] == [CommandKind.PROMISE]
    screenshot(page, f"duty-expected-{language}")
    expect(page.locator(".call-answers")).to_have_count(1)
    expect(card(page, "ATV2").locator(".promises")).to_have_count(0)
    # A third line would touch the edges of its button.
    assert page.locator(".duty-choices .button").evaluate_all(MOST_LINES) <= 2
    screenshot(page, f"duty-card-{language}", of=".duty")
    # The way is clear: nobody is needed any more.
    house.do(beat(vehicle, status=AtvStatus.WORKING, problem="", help=None))
    do(house, lambda _inside: calling.say(state=CallState.ENDED, taken_by="", until_s=None))
    expect(call).to_have_count(0)
    page.get_by_role("button", name=says["off"], exact=True).tap()
    expect(page.get_by_role("button", name=says["off"], exact=True)).to_have_attribute("aria-pressed", "true")
    assert house.until(lambda inside: not on_duty(inside))


@pytest.mark.slow
def test_nobody_chooses_before_the_page_knows_who_it_is(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    """A choice that is kept for nobody would be forgotten: shown as on duty, and never asked."""
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    page = enter(before=lambda page: page.route("**/api/me", hold))
    expect(card(page, "ATV2")).to_be_visible()
    on = page.get_by_role("button", name="On duty", exact=True)
    while not held:
        page.wait_for_timeout(LOOK_MS)
    # What it draws of all that it knows so far is drawn.
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    expect(on).to_have_count(0)
    held.pop().continue_()
    on.tap()
    expect(on).to_have_attribute("aria-pressed", "true")
    calling = vehicle_calls(house, vehicles["ATV2"])
    asks(house, calling)
    expect(page.locator(".call")).to_contain_text("asks you")


@pytest.mark.slow
def test_who_passes_is_not_shown_the_call_any_more(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    calling = vehicle_calls(house, vehicles["ATV2"])
    page = enter()
    page.get_by_role("button", name="On duty", exact=True).tap()
    expect(page.get_by_role("button", name="On duty", exact=True)).to_have_attribute("aria-pressed", "true")
    asks(house, calling)
    page.locator(".call").get_by_role("button", name="Pass").tap()
    expect(page.locator(".call")).to_have_count(0)
    assert calling.answers == [CallAnswer.DECLINE]


def go_on_duty(page: Page) -> None:
    on = page.locator(".duty-choices button").first
    on.tap()
    expect(on).to_have_attribute("aria-pressed", "true")


@pytest.mark.parametrize("theme", variants(["dark", "light"]))
@pytest.mark.parametrize("shape", variants(SHAPES, "upright-dark-de"))
def test_who_is_on_duty_is_called_to_goods_on_board_of_a_dead_vehicle(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    shape: str,
    theme: str,
) -> None:
    def join(inside: House) -> Calling:
        machine = MachineWithGoods(inside, LATER_S)
        return Calling(inside, STATION, machine.on_message, goods=TASK, x_m=25.0, y_m=14.5)

    calling: Calling = do(house, join)
    page = enter(**SHAPES[shape] | {"color_scheme": theme})
    go_on_duty(page)
    asks(house, calling)
    call = page.locator(".call")
    for said in (STATION, "ATV2", REFERENCE, "South middle"):
        expect(call).to_contain_text(said)
    assert_touchable(*call.get_by_role("button").all())
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    screenshot(page, f"goods-call-{shape}-{theme}")
    call.get_by_role("button").first.tap()
    house.until(lambda _inside: calling.answers)
    assert calling.answers == [CallAnswer.TAKE]
    screenshot(page, f"goods-call-taken-{shape}-{theme}")


@pytest.mark.slow
def test_two_tabs_of_one_person_are_on_duty_together_and_go_off_together(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    first = enter()
    go_on_duty(first)
    second = enter(beside=first)
    for page in (first, second):
        expect(page.get_by_role("button", name="On duty", exact=True)).to_have_attribute(
            "aria-pressed", "true"
        )
    asks(house, vehicle_calls(house, vehicles["ATV2"]))
    for page in (first, second):
        expect(page.locator(".call")).to_contain_text("asks you")
    second.get_by_role("button", name="Off duty", exact=True).tap()
    # The first one has chosen to be on duty, and does not put the person back.
    off = first.get_by_role("button", name="Off duty", exact=True)
    expect(off).to_have_attribute("aria-pressed", "true")
    expect(first.locator(".call")).to_have_count(0)
    for _ in range(2):
        with first.expect_response("**/api/duty"):
            pass
    expect(off).to_have_attribute("aria-pressed", "true")
    assert house.until(lambda inside: not on_duty(inside))


@pytest.mark.slow
def test_of_two_people_who_take_a_call_the_slower_one_is_told(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    calling = vehicle_calls(house, vehicles["ATV2"])
    page = enter()
    go_on_duty(page)
    operator = asks(house, calling)
    calling.quicker = "operator.quicker"
    call = page.locator(".call")
    call.get_by_role("button", name="I take it within 5 min").tap()
    expect(page.locator(".call-failed")).to_have_text("Too late: quicker comes to ATV2.")
    expect(call).to_have_count(0)
    assert operator != calling.quicker
    assert vehicles["ATV2"].heard == []
    screenshot(page, "duty-quicker")


@pytest.mark.slow
def test_who_takes_a_second_call_reads_that_somebody_expects_them_already(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, complaints: list[str]
) -> None:
    calling = [vehicle_calls(house, vehicles[atv]) for atv in ("ATV2", "ATV6")]
    page = enter()
    go_on_duty(page)
    for each in calling:
        asks(house, each)
    first, second = (page.locator(".call").filter(has_text=atv) for atv in ("ATV2", "ATV6"))
    first.get_by_role("button", name="I take it within 5 min").tap()
    expect(first).to_contain_text("expects you")
    second.get_by_role("button", name="I take it within 5 min").tap()
    # Where the words of the language are not there within a second, it is said as the gateway says it.
    expect(page.locator(".call-failed")).to_have_text(
        re.compile("You are expected elsewhere already. Give that back first.|ATV2 expects you")
    )
    expect(page.locator(".call-failed")).to_be_in_viewport(ratio=0.9)
    assert [each.answers for each in calling] == [[CallAnswer.TAKE], []]
    screenshot(page, "duty-two-calls")
    assert "409 (Conflict)" in " ".join(complaints)
    complaints.clear()
    first.get_by_role("button", name="Give it back").tap()
    expect(page.locator(".call-failed")).to_have_count(0)
    second.get_by_role("button", name="I take it within 5 min").tap()
    expect(second).to_contain_text("expects you")
    assert [each.answers for each in calling] == [[CallAnswer.TAKE, CallAnswer.DECLINE], [CallAnswer.TAKE]]


@pytest.mark.slow
def test_who_is_asked_elsewhere_reads_where_that_is(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    page = enter()
    go_on_duty(page)
    asks(house, vehicle_calls(house, vehicles["ATV2"], x_m=30.0, y_m=30.0))
    call = page.locator(".call")
    expect(call).to_contain_text("m from you")
    expect(call).to_contain_text("That is not your area")
    screenshot(page, "duty-elsewhere")


@pytest.mark.slow
def test_who_promises_at_the_card_of_a_vehicle_has_taken_its_call(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    vehicle = vehicles["ATV2"]
    calling = vehicle_calls(house, vehicle)
    page = enter()
    go_on_duty(page)
    waits = HelpWanted(until_s=SOON_S)
    house.do(beat(vehicle, status=AtvStatus.ERROR, problem="a pallet", about_problem=BLOCKED, help=waits))
    house.until(on_duty)
    do(
        house,
        lambda _inside: calling.say(state=CallState.ASKING, asked=("operator.another",), until_s=SOON_S),
    )
    expect(page.locator(".duty-open")).to_contain_text("ATV2")
    promise = card(page, "ATV2").locator(".promises button").nth(1)
    expect(promise).to_be_visible()
    settle(page)
    promise.tap()
    expect(page.locator(".call")).to_contain_text("expects you")
    house.until(lambda _inside: vehicle.heard)
    assert [command.kind for command in vehicle.heard] == [CommandKind.PROMISE]


@pytest.mark.slow
def test_a_person_says_what_for_and_until_when_busy(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    page = enter()
    go_on_duty(page)
    page.get_by_role("button", name="More").tap()
    page.locator(".duty-for summary").tap()
    for kind in ("Drives", "Loads"):
        page.get_by_role("button", name=kind, exact=True).tap()
        expect(page.get_by_role("button", name=kind, exact=True)).to_have_attribute("aria-pressed", "true")
    page.locator(".duty-busy button").first.tap()
    expect(page.locator(".duty-busy")).to_contain_text("Busy until")
    screenshot(page, "duty-what-for", of=".duty")
    page.reload()
    page.get_by_role("button", name="More").tap()
    expect(page.locator(".duty-for summary")).to_contain_text("Drives")

    def said(inside: House) -> list[tuple[DutyStatus, tuple[ProblemKind, ...]]]:
        return [(each.status, each.helps_with) for each in inside.projection.people.on_duty(0.0)]

    wanted = [(DutyStatus.BUSY, (ProblemKind.DRIVE, ProblemKind.LOAD))]
    assert house.until(lambda inside: said(inside) == wanted)


@pytest.mark.slow
def test_a_manager_sees_who_is_on_duty_and_where_nobody_is(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, open_page: OpenPage, screenshot: Screenshot
) -> None:
    manager = as_manager(house, open_page)
    row = manager.locator(".duty-row")
    expect(row).to_contain_text("nobody")
    go_on_duty(enter())
    expect(row).to_contain_text("1 on duty")
    expect(row).to_contain_text("Nobody is on duty: ")
    expect(row.locator("p")).not_to_contain_text("South middle")
    row.locator("summary").click()
    expect(row.get_by_role("listitem")).to_contain_text("M8 · South middle · free")
    screenshot(manager, "manager-duty")


UNTOLD = "it has not told any place yet: the vehicle has not said where it is"


@pytest.mark.parametrize("width_px", [1280, 360])
def test_a_vehicle_that_tells_no_place_calls_and_the_tablet_and_the_manager_are_told_so(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    open_page: OpenPage,
    screenshot: Screenshot,
    width_px: int,
) -> None:
    problem = Problem(kind=ProblemKind.LOST_POSITION, needs_person=True)
    calling = vehicle_calls(house, vehicles["ATV2"], problem=problem, reason=UNTOLD, place=CallPlace.UNTOLD)
    look = {"viewport": {"width": width_px, "height": 844}, "locale": "en-GB"}
    page: Page = enter(**look)
    page.get_by_role("button", name="On duty", exact=True).tap()
    asks(house, calling)
    call = page.locator(".call")
    # It is said once.
    expect(call.locator("p").nth(0)).to_have_text(f"{UNTOLD}. ")
    expect(call.locator("p").nth(1)).to_have_text("Look for it; in the plant file it starts in South middle.")
    expect(call).not_to_contain_text("from you")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    screenshot(page, f"unplaced-tablet-{width_px}")
    manager = as_manager(house, open_page, color_scheme="dark", **look)
    manager.goto(f"{house.url}/#alerts")
    row = manager.get_by_role("row", name=re.compile("ATV2.*Tells no place, and calls a person")).first
    expect(row).to_contain_text("Look for it, and see to its position and its link")
    assert manager.evaluate("document.documentElement.scrollWidth <= innerWidth")
    screenshot(manager, f"unplaced-alert-{width_px}")
