"""Cards of vehicles that come and go: none comes under a hand that was over another one, and no open form is lost."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from gateway_kit import House
from open_house import OpenHouse
from playwright.sync_api import Page, expect
from puppets import Puppet
from tablet_kit import IN_AREA, LOOKS, LYING, PHONE, UPRIGHT, Enter, beat, card, kinds
from wall_clock import NOW_S

from dray.messages import AtvStatus, CommandKind

Screenshot = Callable[..., Path]

AWAY = (25.0, 35.0)
"""Outside of the area."""

SETTLE_MS = 600
"""Until a card that has moved counts touches: some more than the panel waits."""

TOUCH_AT_ONCE = """new Promise(done => {
    const list = document.querySelector(".cards.well");
    new MutationObserver((_, looking) => {
        if (document.querySelector("#vehicle-ATV2")) return;
        looking.disconnect();
        const button = document.querySelector("#vehicle-ATV6 .steps button");
        const touch = {bubbles: true, cancelable: true, detail: 1};
        button.dispatchEvent(new PointerEvent("pointerdown", touch));
        button.dispatchEvent(new MouseEvent("click", touch));
        done();
    }).observe(list, {childList: true});
})"""
"""A finger that is down in the very moment in which a card has moved up."""


IS_WHOLE = "h1 => h1.scrollWidth <= h1.clientWidth && h1.scrollHeight <= h1.clientHeight"


def drive(vehicle: Puppet, place: tuple[float, float]) -> Callable[[House], None]:
    async def say(_house: House) -> None:
        vehicle.x_m, vehicle.y_m = place
        vehicle.beat()

    return say


@pytest.mark.parametrize(
    ("look", "gone"),
    [
        ("lying-light-en", "has left your area"),
        ("upright-dark-de", "Ihren Bereich verlassen"),
        ("phone-dark-es", "Ha salido de su zona"),
    ],
)
def test_an_open_form_stays_when_its_vehicle_leaves_and_is_sent_when_it_is_back(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str, gone: str
) -> None:
    page = enter(**LOOKS[look])
    own = card(page, "ATV2")
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    expect(page.locator(".vehicle.settling")).to_have_count(0)
    own.locator(".service-open").tap()
    form = own.locator(".service")
    form.locator("button").nth(1).tap()
    house.do(drive(vehicles["ATV2"], AWAY))
    expect(own).to_contain_text(gone)
    expect(form.locator("button").nth(1)).to_have_attribute("aria-pressed", "true")
    expect(form.locator("button").nth(5)).to_be_disabled()
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    own.scroll_into_view_if_needed()
    screenshot(page, f"operator-form-left-{look}")
    house.do(drive(vehicles["ATV2"], IN_AREA["ATV2"]))
    form.locator("button").nth(5).tap()
    expect(form).to_have_count(0)
    expect(own.locator(".service-back")).to_be_visible()
    assert kinds(vehicles["ATV2"]) == [CommandKind.TAKE_OUT]


def test_a_card_that_moves_up_counts_no_touch_at_first_and_says_so(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    page.evaluate("window.touched = " + TOUCH_AT_ONCE + "; 0")
    house.do(drive(vehicles["ATV2"], AWAY))
    expect(card(page, "ATV2")).to_contain_text("has left")
    expect(card(page, "ATV2").locator(".steps button").first).to_be_visible()
    page.evaluate("window.touched")
    expect(card(page, "ATV6")).to_contain_text("new here: touch again")
    assert kinds(vehicles["ATV6"]) == []
    expect(card(page, "ATV6")).not_to_contain_text("touch again")
    card(page, "ATV6").locator(".steps button").first.tap()
    expect(card(page, "ATV6").locator(".command")).to_contain_text("confirmed by the vehicle")
    assert kinds(vehicles["ATV6"]) == [CommandKind.SET_SPEED]


def test_a_card_that_moves_shows_how_long_it_counts_no_touch(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    page = enter(before=lambda page: page.clock.install(time=NOW_S))
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    page.clock.pause_at(NOW_S + 60)
    house.do(beat(vehicles["ATV2"], status=AtvStatus.STOPPED))
    own = card(page, "ATV2")
    acknowledge = own.get_by_role("button", name="Fault is gone")
    for _ in range(200):
        if acknowledge.is_visible():
            break
        page.clock.run_for(50)
    expect(own).to_contain_class("settling")
    screenshot(page, "operator-settling", audited=False)
    acknowledge.tap()
    page.clock.run_for(50)
    expect(own).to_contain_text("new here: touch again")
    assert kinds(vehicles["ATV2"]) == []
    page.clock.run_for(SETTLE_MS)
    expect(own).not_to_contain_class("settling")
    acknowledge.tap()
    house.until(lambda _house: vehicles["ATV2"].heard)
    assert kinds(vehicles["ATV2"]) == [CommandKind.ACKNOWLEDGE]
    page.clock.resume()


def test_who_joins_is_below_those_who_are_there(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6"])
    house.do(lambda inside: Puppet.join(inside, "ATV1", *IN_AREA["ATV2"]))
    expect(page.locator(".vehicle h2")).to_have_text(["ATV2", "ATV6", "ATV1"])


def test_the_stations_name_is_whole(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    page: Page = enter()
    name = page.get_by_role("heading", level=1)
    expect(name).to_have_text("M8 · Assembly cell 4")
    for size in (PHONE, UPRIGHT, LYING):
        page.set_viewport_size({"width": size["width"], "height": size["height"]})
        assert name.evaluate(IS_WHOLE), size
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), size
        screenshot(page, f"operator-header-{size['width']}")
