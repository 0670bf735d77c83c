"""Where the factory's clock runs otherwise than the one on the wall, every length of time says by which of them it is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from manager_kit import as_manager, choose
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from puppets import Puppet
from tablet_kit import Enter, ask_for_help, card

Screenshot = Callable[..., Path]

SLOW = 0.05
"""Factory seconds per real second: what is heard of a vehicle is not old before a slow browser has drawn it."""

WORDS = {
    "en-GB": ("of factory time", "I am on my way (factory time)"),
    "de-DE": ("Werkszeit", "(Werkszeit)"),
    "es-ES": ("de fábrica", "(tiempo de fábrica)"),
}


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, speed=SLOW) as house:
        yield house


@pytest.mark.parametrize("locale", WORDS)
def test_a_tablet_names_the_clock_of_what_it_asks_and_offers(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, locale: str
) -> None:
    house.do(ask_for_help(vehicles["ATV2"]))
    page = enter(locale=locale)
    time, title = WORDS[locale]
    help_ = card(page, "ATV2").locator(".help")
    expect(help_.locator(".countdown")).to_have_text(re.compile(rf"min {time}$"))
    expect(help_.get_by_role("group", name=title)).to_be_visible()
    screenshot(page, f"clock-tablet-{locale}")


def test_so_does_the_card_of_the_manager(
    house: OpenHouse, vehicles: dict[str, Puppet], open_page: Callable[..., Page]
) -> None:
    house.do(ask_for_help(vehicles["ATV2"]))
    page = as_manager(house, open_page)
    choose(page, "ATV2")
    expect(page.locator(".card.atv .problem")).to_contain_text(re.compile(r"min of factory time"))
