"""A tablet whose network is cut: what it says, and what comes when the network is back."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from complaints import Complaints
from open_house import OpenHouse
from playwright.sync_api import Page, Route, expect
from puppets import Puppet
from tablet_kit import Cable, Enter, beat, card, forgive, kinds, stop_of

from dray.messages import AtvStatus

Screenshot = Callable[..., Path]


@pytest.mark.slow
def test_a_cut_network_is_said_and_no_command_waits_for_its_end(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    cable = Cable()
    page = enter(before=cable.lay)
    expect(page.locator(".vehicle")).to_have_count(2)
    cable.pull()
    banner = page.locator(".banner")
    expect(banner).to_contain_text("No connection to the plant")
    expect(banner).to_contain_text("In danger use the button on the vehicle")
    moved = card(page, "ATV2")
    expect(moved.get_by_role("button", name="At most 50")).to_be_disabled()
    screenshot(page, "operator-offline")
    stop_of(page, "ATV2").tap()
    expect(moved.locator(".stage")).to_have_text(["could not be sent"])
    expect(stop_of(page, "ATV2")).to_contain_text("could not be sent")
    house.do(beat(vehicles["ATV6"], status=AtvStatus.CHARGING))
    cable.plug_in()
    expect(banner).to_be_hidden()
    expect(card(page, "ATV6")).to_contain_text("charging")
    expect(moved.get_by_role("button", name="At most 50")).to_be_enabled()
    assert kinds(vehicles["ATV2"]) == [], "a stop is given when it is pressed, or not at all"
    forgive(complaints, "ERR_INTERNET_DISCONNECTED")


def test_a_part_whose_script_was_cut_off_comes_when_the_network_is_back(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, complaints: Complaints
) -> None:
    """The words that the part needs are cut off as well; so is the language that is chosen meanwhile."""
    lost: list[str] = []

    def lose(route: Route) -> None:
        lost.append(route.request.url)
        route.abort("internetdisconnected")

    def cut(page: Page) -> None:
        page.route("**/assets/Pieces-*.js", lose)
        page.route("**/assets/es-*.js", lose)

    # The service worker would bring what it keeps.
    page = enter(before=cut, service_workers="block")
    expect(card(page, "ATV2")).to_be_visible()
    page.get_by_role("button", name="Settings").tap()
    page.get_by_label("Language").select_option("es")
    station = page.locator(".station .pieces")
    expect(station).to_have_count(0)
    expect(page.get_by_label("Language")).to_be_visible()
    for part in ("Pieces", "es"):
        if not any(f"/{part}-" in url for url in lost):
            page.wait_for_event("requestfailed", lambda request, part=part: f"/{part}-" in request.url)
    page.unroute_all()
    expect(station).to_be_visible()
    expect(page.locator("html")).to_have_attribute("lang", "es")
    forgive(complaints, "ERR_INTERNET_DISCONNECTED", "Service Worker registration blocked")
