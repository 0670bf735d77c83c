"""An operator goes on duty, is asked by a vehicle whose way is blocked, takes the call, comes, and is free again (paper, case 4)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from fake_bus import KEYS, FakeSession
from gateway_kit import House
from msgspec.structs import replace
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, Route, expect
from puppets import Puppet
from tablet_kit import LYING, TOUCH_PX, UPRIGHT, Enter, beat, card
from variants import variants

from dray.messages import (
    AtvStatus,
    CallAnswer,
    CallAnswered,
    CallState,
    CommandKind,
    HelpCall,
    HelpWanted,
    Message,
    Problem,
    ProblemKind,
)

Screenshot = Callable[..., Path]

BLOCKED = Problem(kind=ProblemKind.WAY_BLOCKED, passes=False, needs_person=True)

SOON_S = 3600.0
"""Browsers' clocks go on while that of the kit stands: nothing runs out in a test."""

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
            "on": "De servicio",
            "asks": "le pregunta",
            "take": "Voy yo en 5 min",
            "expects": "le espera",
            "off": "Fuera de servicio",
        },
    ),
}


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    """A gateway at which people can be on duty."""
    with open_house(sqlite_url, duty=True) as house:
        yield house


class Calling:
    """A vehicle that calls for help: it says so, and takes whoever says to come."""

    def __init__(self, house: House, puppet: Puppet) -> None:
        self.answers: list[CallAnswer] = []
        self._house, self._puppet = house, puppet
        self._call = HelpCall(
            call=f"{puppet.atv}-1-1",
            caller=puppet.atv,
            incarnation=1,
            number=0,
            at_s=0.0,
            state=CallState.RESTING,
            since_s=0.0,
            problem=BLOCKED,
            reason="a pallet on the lane",
            x_m=puppet.x_m,
            y_m=puppet.y_m,
        )
        house.bus.join(puppet.atv, self._on_message)

    def say(self, **said: Any) -> None:
        self._call = replace(self._call, number=self._call.number + 1, **said)
        FakeSession(self._house.bus, self._puppet.atv, self._on_message).publish(
            KEYS.call(self._puppet.atv), self._call
        )

    def _on_message(self, sender: str, message: Message) -> None:
        if isinstance(message, CallAnswered):
            self.answers.append(message.answer)
            if message.answer is CallAnswer.TAKE:
                self.say(state=CallState.TAKEN, taken_by=sender, turn=1, asked=(), until_s=SOON_S)
        else:
            self._puppet.on_message(sender, message)


def do(house: OpenHouse, what: Callable[[House], Any]) -> Any:
    async def work(inside: House) -> Any:
        return what(inside)

    return house.do(work)


def on_duty(inside: House) -> list[str]:
    return [each.operator for each in inside.projection.people.on_duty(0.0)]


@pytest.mark.parametrize("language", variants(["de", "en", "es"]))
def test_an_operator_on_duty_is_asked_takes_a_blocked_way_and_is_free_again(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, language: str
) -> None:
    look, says = LOOKS[language]
    vehicle = vehicles["ATV2"]
    calling: Calling = do(house, lambda inside: Calling(inside, vehicle))
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
    for button in call.get_by_role("button").all():
        box = button.bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) >= TOUCH_PX
    screenshot(page, f"duty-asked-{language}")
    call.get_by_role("button", name=says["take"]).tap()
    expect(call).to_contain_text(says["expects"])
    # The page may have asked anew before the vehicle was told.
    house.until(lambda _inside: vehicle.heard)
    assert calling.answers == [CallAnswer.TAKE]
    assert [command.kind for command in vehicle.heard] == [CommandKind.PROMISE]
    screenshot(page, f"duty-expected-{language}")
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
    page.wait_for_timeout(500)
    expect(on).to_have_count(0)
    held.pop().continue_()
    on.tap()
    expect(on).to_have_attribute("aria-pressed", "true")
    calling: Calling = do(house, lambda inside: Calling(inside, vehicles["ATV2"]))
    [operator] = house.until(on_duty)
    do(house, lambda _inside: calling.say(state=CallState.ASKING, asked=(operator,), until_s=SOON_S))
    expect(page.locator(".call")).to_contain_text("asks you")


@pytest.mark.slow
def test_who_passes_is_not_shown_the_call_any_more(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    calling: Calling = do(house, lambda inside: Calling(inside, vehicles["ATV2"]))
    page = enter()
    page.get_by_role("button", name="On duty", exact=True).tap()
    expect(page.get_by_role("button", name="On duty", exact=True)).to_have_attribute("aria-pressed", "true")
    [operator] = house.until(on_duty)
    do(house, lambda _inside: calling.say(state=CallState.ASKING, asked=(operator,), until_s=SOON_S))
    page.locator(".call").get_by_role("button", name="Pass").tap()
    expect(page.locator(".call")).to_have_count(0)
    assert calling.answers == [CallAnswer.DECLINE]
