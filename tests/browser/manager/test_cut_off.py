"""A panel that is cut off says so of itself: it calls nobody silent, and offers nothing that is for who is silent."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from complaints import Complaints
from drawn_words import pictures_of, watch_words, words_of
from manager_kit import BEAT_S, GoingWall, as_manager, choose
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from puppets import Puppet
from tablet_kit import Cable, Enter, be_cut_off, can_be_cut_off, forgive

from dray.messages.heartbeat import FloorBrief
from dray.plant import load_plant

from gateway_kit import House  # isort: skip - their folder is on the path since `puppets` is
from wall_clock import NOW_S  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PLANT = load_plant("single-track")
STAND = {"ATV2": "a1", "ATV5": "c3", "ATV7": "m8", "ATV8": "e1"}


class Fleet:
    """Vehicles that hold the places where they stand, and say so. That who is silent is told so, test_carrying holds."""

    def __init__(self, house: House) -> None:
        self._house = house
        self._puppets: list[Puppet] = []
        self._telling: asyncio.Task[None] | None = None

    @classmethod
    async def join(cls, house: House) -> Fleet:
        fleet = cls(house)
        for atv, node in STAND.items():
            spot = PLANT.nodes[node]
            state = {"node": node, "floor": FloorBrief((node,)), "at_s": fleet._at_s()}
            fleet._puppets.append(await Puppet.join(house, atv, spot.x_m, spot.y_m, **state))
        fleet._telling = asyncio.create_task(fleet._tell())
        return fleet

    async def leave(self, _house: House) -> None:
        assert self._telling is not None
        self._telling.cancel()
        with suppress(asyncio.CancelledError):
            await self._telling

    async def _tell(self) -> None:
        while True:
            for puppet in self._puppets:
                puppet.beat(at_s=self._at_s())
            await asyncio.sleep(BEAT_S)

    def _at_s(self) -> float:
        return self._house.wall() - NOW_S


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


@pytest.fixture
def fleet(house: OpenHouse) -> Iterator[Fleet]:
    fleet = house.do(Fleet.join)
    yield fleet
    house.do(fleet.leave)


@pytest.fixture
def cable() -> Cable:
    return Cable()


@pytest.fixture
def before(cable: Cable) -> Callable[[Page], None]:
    """A page whose network can be cut, and whose clock can be put forward."""

    def prepare(page: Page) -> None:
        can_be_cut_off(page, cable)
        watch_words(page)

    return prepare


def test_a_manager_whose_panel_is_cut_off_reads_that_and_of_no_vehicle_that_it_is_silent(
    house: OpenHouse,
    fleet: Fleet,
    cable: Cable,
    before: Callable[[Page], None],
    open_page: OpenPage,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    page = as_manager(house, open_page, before=before)
    counts = page.locator(".factory .status-row").first
    expect(counts).to_contain_text(f"{len(STAND)} idle")
    choose(page, "ATV5")
    vehicle = page.locator(".card.atv")
    expect(vehicle).to_contain_text("ATV5")
    said = counts.inner_text()
    be_cut_off(page, cable)
    assert counts.inner_text() == said
    expect(vehicle.locator(".tag-alarm")).to_have_count(0)
    expect(vehicle.locator(".carrying")).to_have_count(0)
    # On the map a silent vehicle has its age beside its name. Cut off, it is drawn anew for who looks elsewhere.
    drawn = pictures_of(page)
    page.get_by_role("button", name="Areas", exact=True).click()
    words = words_of(page, after=drawn)
    assert [word.text for word in words if word.text.startswith("ATV5")] == ["ATV5"]
    screenshot(page, "cut-off-manager")
    cable.plug_in()
    expect(page.locator(".banner")).to_have_count(0)
    forgive(complaints, "ERR_INTERNET_DISCONNECTED")


def test_so_does_an_operator_at_the_tablet(
    house: OpenHouse,
    fleet: Fleet,
    cable: Cable,
    before: Callable[[Page], None],
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    page = enter(before=before)
    near = page.locator(".vehicle")
    expect(near.first).to_be_visible()
    be_cut_off(page, cable)
    expect(page.locator(".carrying")).to_have_count(0)
    expect(page.locator(".needing .vehicle")).to_have_count(0)
    screenshot(page, "cut-off-operator")
    cable.plug_in()
    expect(page.locator(".banner")).to_have_count(0)
    forgive(complaints, "ERR_INTERNET_DISCONNECTED")
