"""A silent vehicle is carried away and put back, step by step: on the tablet and at the vehicle's card."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from complaints import Complaints
from manager_kit import BEAT_S, GoingWall, as_manager, choose
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect
from puppets import Puppet
from tablet_kit import LOOKS, Cable, Enter, be_cut_off, can_be_cut_off, card, forgive
from variants import variants

from dray.messages import Event, RemovalRefusal
from dray.messages.fact import PlaceKept, PlacesFreed, RemovalRefused
from dray.messages.heartbeat import FloorBrief
from dray.plant import load_plant

from gateway_kit import House  # isort: skip - their folder is on the path since `puppets` is
from heartbeats import machine_heartbeat  # isort: skip
from wall_clock import NOW_S  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PLANT = load_plant("single-track")
DEAD, HERE = "ATV3", "c2"
OTHERS = {"ATV2": "a1", "ATV5": "c3", "ATV7": "m8", "ATV8": "e1"}

WORDS = {
    "en": ("Carry ATV3 away", "It is off the floor", "Keep this place", "is kept for it"),
    "de": ("ATV3 wegtragen", "Es ist weggetragen", "Diesen Platz freihalten", "ist freigehalten"),
    "es": ("Retirar ATV3", "Ya no está en el suelo", "Reservar este lugar", "está reservado"),
}

REFUSED = {
    "en": "a machine may have heard it after this report",
    "de": "Eine Maschine hat es vielleicht nach dieser Meldung gehört",
    "es": "puede que una máquina lo haya oído después de este aviso",
}


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


@pytest.fixture
def dead(house: OpenHouse) -> Puppet:
    """ATV3 was heard last 40 s ago; the others go on."""

    async def join(inside: House) -> Puppet:
        def at_s() -> float:
            return inside.wall() - NOW_S

        async def go_on() -> None:
            while True:
                for puppet in others:
                    puppet.beat(at_s=at_s())
                await asyncio.sleep(BEAT_S)

        async def stand(atv: str, node: str) -> Puppet:
            spot = PLANT.nodes[node]
            state = {"node": node, "floor": FloorBrief((node,)), "at_s": at_s()}
            return await Puppet.join(inside, atv, spot.x_m, spot.y_m, **state)

        dead = await stand(DEAD, HERE)
        inside.wall.now_s += 40.0
        others = [await stand(atv, node) for atv, node in OTHERS.items()]
        inside.telling = asyncio.create_task(go_on())  # type: ignore[attr-defined]
        return dead

    return house.do(join)


HEARD_SINCE = {
    "en": "The vehicle was heard there after this report",
    "de": "Das Fahrzeug wurde dort nach dieser Meldung gehört",
    "es": "El vehículo se oyó allí después de este aviso",
}


def tell(
    house: OpenHouse, number: int, fact: PlacesFreed | PlaceKept | RemovalRefused, agent: str = "M8"
) -> None:
    async def say(inside: House) -> None:
        inside.bus.say(Event(agent=agent, incarnation=1, number=number, at_s=0.0, fact=fact))

    house.do(say)


def number_of(house: OpenHouse) -> int:
    async def ask(inside: House) -> int:
        view = inside.projection.removals.view(DEAD)
        assert view is not None
        return view.number

    return house.do(ask)


@pytest.mark.slow
@pytest.mark.parametrize("look", variants(LOOKS, "upright-dark-de"))
def test_an_operator_carries_a_vehicle_away_and_puts_it_back(
    enter: Enter, house: OpenHouse, dead: Puppet, screenshot: Screenshot, look: str
) -> None:
    begin, off, keep, kept = WORDS[look[-2:]]
    page = enter(**LOOKS[look])
    steps = card(page, DEAD).locator(".carrying")
    expect(card(page, "ATV5").locator(".carrying")).to_have_count(0)
    steps.get_by_text(begin).click()
    expect(steps.get_by_role("listitem")).to_have_count(3)
    expect(steps.get_by_role("button", name=off)).to_be_disabled()
    steps.get_by_role("checkbox").check()
    screenshot(page, f"carry-away-{look}")
    steps.get_by_role("button", name=off).click()
    expect(steps).to_contain_text("Operator-South")
    tell(house, 1, PlacesFreed(atv=DEAD, number=number_of(house), by="x", places=(HERE,)))
    expect(steps).to_contain_text(HERE)

    steps.get_by_role("combobox").select_option(index=0)
    steps.get_by_role("button", name=keep).click()
    expect(steps.get_by_role("status")).to_be_visible()
    place = house.do(_node)
    tell(house, 2, PlaceKept(atv=DEAD, number=number_of(house), place=place))
    expect(steps.get_by_role("status")).to_contain_text(kept)
    screenshot(page, f"put-back-{look}")
    dead.seq += 1
    house.do(lambda inside: _speak(inside, dead))
    expect(steps).to_have_count(0)


@pytest.mark.slow
@pytest.mark.parametrize("look", variants(LOOKS, "upright-dark-de"))
def test_if_its_places_do_not_become_free_its_card_says_why_and_what_to_do(
    enter: Enter, house: OpenHouse, dead: Puppet, screenshot: Screenshot, look: str
) -> None:
    begin, off, _, _ = WORDS[look[-2:]]
    page = enter(**LOOKS[look])
    steps = card(page, DEAD).locator(".carrying")
    steps.get_by_text(begin).click()
    steps.get_by_role("checkbox").check()
    steps.get_by_role("button", name=off).click()
    expect(steps).to_contain_text("Operator-South")
    expect(steps.get_by_role("alert")).to_have_count(0)
    house.do(_wait)
    expect(steps.get_by_role("alert")).to_contain_text(REFUSED[look[-2:]])
    screenshot(page, f"carry-refused-{look}")
    number = number_of(house)
    for agent in ("M8", "M7", "M1"):
        tell(house, 1, RemovalRefused(DEAD, number, RemovalRefusal.HEARD_SINCE), agent)
    expect(steps.get_by_role("alert")).to_contain_text(HEARD_SINCE[look[-2:]])
    expect(steps.get_by_role("alert")).not_to_contain_text(REFUSED[look[-2:]])
    expect(steps.get_by_role("alert")).to_contain_text("M8")
    screenshot(page, f"carry-refused-why-{look}")
    tell(house, 2, PlacesFreed(atv=DEAD, number=number, by="x", places=(HERE,)))
    expect(steps.get_by_role("alert")).to_have_count(0)


@pytest.mark.slow
def test_a_manager_does_so_at_the_vehicle(
    house: OpenHouse, dead: Puppet, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = as_manager(house, open_page)
    choose(page, DEAD)
    steps = page.locator(".card.atv .carrying")
    steps.get_by_text("Carry ATV3 away").click()
    steps.get_by_role("checkbox").check()
    screenshot(page, "carry-away-manager")
    steps.get_by_role("button", name="It is off the floor").click()
    expect(steps).to_contain_text("Carried away")
    steps.get_by_role("button", name="Keep this place").click()
    expect(steps.get_by_role("status")).to_contain_text("Do not put it down yet")
    screenshot(page, "put-back-manager")


async def _node(inside: House) -> str:
    view = inside.projection.removals.view(DEAD)
    assert view is not None
    return view.node


async def _wait(inside: House) -> None:
    """Longer than any machine needs to believe a report."""
    inside.wall.now_s += 200.0


async def _speak(inside: House, dead: Puppet) -> None:
    dead.beat(at_s=inside.wall() - NOW_S)


OFF_NOW = "No connection to the plant: it cannot be said now"


@pytest.mark.slow
@pytest.mark.parametrize("panel", ["manager", "operator"])
def test_whose_panel_is_cut_off_cannot_say_that_it_is_off_the_floor_and_reads_why(
    house: OpenHouse,
    dead: Puppet,
    open_page: OpenPage,
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
    panel: str,
) -> None:
    cable = Cable()

    def before(page: Page) -> None:
        can_be_cut_off(page, cable)

    if panel == "manager":
        page = as_manager(house, open_page, before=before)
        choose(page, DEAD)
        steps = page.locator(".card.atv .carrying")
    else:
        page = enter(before=before)
        steps = card(page, DEAD).locator(".carrying")
    steps.get_by_text("Carry ATV3 away").click()
    steps.get_by_role("checkbox").check()
    off = steps.get_by_role("button", name="It is off the floor")
    expect(off).to_be_enabled()
    be_cut_off(page, cable)
    expect(off).to_be_disabled()
    expect(steps.get_by_role("status")).to_contain_text(OFF_NOW)
    screenshot(page, f"carry-cut-off-{panel}")
    cable.plug_in()
    expect(off).to_be_enabled()
    forgive(complaints, "ERR_INTERNET_DISCONNECTED")


@pytest.mark.slow
def test_of_a_vehicle_that_was_never_heard_it_is_said_at_its_alert(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot
) -> None:
    async def await_it(inside: House) -> None:
        at_s = inside.wall() - NOW_S
        for machine in ("M3", "M4"):
            inside.bus.say(machine_heartbeat(machine, 1, at_s=at_s, awaits=("ATV7",)))
        await inside.alerts.look()

    house.do(await_it)
    page = as_manager(house, open_page)
    page.locator(".alerts-button").click()
    row = page.get_by_role("row", name="ATV7").first
    expect(row).to_contain_text("M3, M4 grant no place")
    row.get_by_role("button", name="ATV7 is off the floor").click()
    expect(row.get_by_role("button", name="Not yet")).to_be_focused()
    screenshot(page, "awaited")
    row.get_by_role("button", name="It is off the floor").click()
    expect(row.get_by_role("status")).to_contain_text("Told to all")
    assert house.do(_is_removed)


@pytest.mark.slow
def test_why_it_cannot_be_said_at_the_alerts_now_stands_there_once_for_all_of_them(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot, complaints: Complaints
) -> None:
    awaited = ("ATV6", "ATV7")

    async def await_them(inside: House) -> None:
        at_s = inside.wall() - NOW_S
        for machine in ("M3", "M4"):
            inside.bus.say(machine_heartbeat(machine, 1, at_s=at_s, awaits=awaited))
        await inside.alerts.look()

    house.do(await_them)
    cable = Cable()
    page = as_manager(house, open_page, before=lambda page: can_be_cut_off(page, cable))
    page.locator(".alerts-button").click()
    off = [page.get_by_role("button", name=f"{atv} is off the floor") for atv in awaited]
    for each in off:
        expect(each).to_be_enabled()
    be_cut_off(page, cable)
    for each in off:
        expect(each).to_be_disabled()
    expect(page.get_by_role("status").filter(has_text=OFF_NOW)).to_have_count(1)
    screenshot(page, "awaited-cut-off")
    cable.plug_in()
    for each in off:
        expect(each).to_be_enabled()
    forgive(complaints, "ERR_INTERNET_DISCONNECTED")


async def _is_removed(inside: House) -> bool:
    return "ATV7" in inside.projection.removals
