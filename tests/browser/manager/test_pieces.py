"""Good and bad pieces of a machine, on its card and at the operator's station."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from manager_kit import as_manager, choose
from open_house import OpenHouse
from playwright.sync_api import Locator, Page, expect
from puppets import Puppet
from tablet_kit import LOOKS, STATION, Enter

from dray.messages.fact import PieceMade, PieceScrapped

from gateway_kit import PRODUCT, House  # isort: skip - their folder is on the path since `tablet_kit` is
from heartbeats import events  # isort: skip
from wall_clock import NOW_S  # isort: skip

Screenshot = Callable[..., Path]


@pytest.fixture(autouse=True)
def _made(house: OpenHouse) -> None:
    """Three good pieces and a bad one at the station, and one at another machine."""

    async def keep(inside: House) -> None:
        good = (PieceMade("G1", PRODUCT, made) for made in (1, 2, 3))
        told = [
            *events(STATION, *good, PieceScrapped(PRODUCT), at_s=NOW_S - 60.0),
            *events("M1", PieceMade("G2", PRODUCT, 1), at_s=NOW_S - 60.0),
        ]
        async with inside.store.write() as work:
            await work.piece_hours.add(told, lambda at_s: at_s)

    house.do(keep)


def counts(pieces: Locator) -> Locator:
    return pieces.locator("tbody td")


def test_the_card_of_a_machine_tells_its_good_and_bad_pieces(
    house: OpenHouse, vehicles: dict[str, Puppet], open_page: Callable[..., Page], screenshot: Screenshot
) -> None:
    page = as_manager(house, open_page)
    choose(page, STATION)
    pieces = page.locator(".card.machine").get_by_role("table")
    expect(pieces).to_contain_text("Pieces since")
    expect(counts(pieces)).to_have_text(["3", "1", "75.0\u202f%"])
    screenshot(page, "pieces-manager")
    choose(page, "M1")
    expect(counts(pieces)).to_have_text(["1", "0", "100.0\u202f%"])
    choose(page, "M2")
    expect(page.locator(".card.machine")).to_contain_text("No piece was finished since")


@pytest.mark.parametrize(("look", "title"), [("lying-light-en", "Pieces"), ("upright-dark-de", "Stücke")])
def test_so_does_the_tablet_at_its_station(
    vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str, title: str
) -> None:
    page = enter(**LOOKS[look])
    pieces = page.locator(".station").get_by_role("table")
    expect(pieces).to_contain_text(title)
    expect(counts(pieces)).to_have_count(3)
    expect(counts(pieces).first).to_have_text("3")
    pieces.scroll_into_view_if_needed()
    screenshot(page, f"pieces-tablet-{look}")
