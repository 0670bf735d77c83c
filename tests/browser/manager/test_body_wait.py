"""What a vehicle's body waits for, since when and until what: on its card in the management panel, and on the tablet."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from manager_kit import as_manager, choose
from open_house import OpenHouse
from playwright.sync_api import Page, expect
from puppets import LATER_S, Puppet
from tablet_kit import LOOKS, Enter

from dray.messages import BodyWait

from gateway_kit import House  # isort: skip - its folder is on the path since `tablet_kit` is

Screenshot = Callable[..., Path]

WAIT = BodyWait(
    "order ATV1-1-7 is cancelled",
    since_s=LATER_S,
    until="cancelOrder has ended, or it has nothing left to do",
)


@pytest.fixture
def waiting(house: OpenHouse, vehicles: dict[str, Puppet]) -> str:
    """A vehicle near the station that waits."""
    puppet = next(iter(vehicles.values()))

    async def beat(_inside: House) -> None:
        puppet.beat(body_wait=WAIT)

    house.do(beat)
    return puppet.atv


def test_the_card_of_a_vehicle_says_what_its_body_waits_for(
    house: OpenHouse, waiting: str, open_page: Callable[..., Page], screenshot: Screenshot
) -> None:
    page = as_manager(house, open_page)
    choose(page, waiting)
    card = page.locator(".card.atv")
    expect(card).to_contain_text("Waiting for ")
    expect(card).to_contain_text(f": {WAIT.what} (until {WAIT.until})")
    screenshot(page, "body-wait-manager")


@pytest.mark.parametrize(
    ("look", "begins", "says"),
    [
        ("lying-light-en", "Waiting for ", f": {WAIT.what} (until {WAIT.until})"),
        (
            "upright-dark-de",
            "Wartet seit ",
            ": der Fahrauftrag ATV1-1-7 wird abgebrochen (bis cancelOrder beendet ist oder es nichts mehr zu tun hat)",
        ),
    ],
)
def test_so_does_the_tablet(
    waiting: str, enter: Enter, screenshot: Screenshot, look: str, begins: str, says: str
) -> None:
    page = enter(**LOOKS[look])
    card = page.locator(f"#vehicle-{waiting}")
    expect(card).to_contain_text(begins)
    expect(card).to_contain_text(says)
    card.scroll_into_view_if_needed()
    screenshot(page, f"body-wait-{look}")
