"""Something is brought to the own station in two touches, and its way is followed until it is there; what is called too much is called off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from gateway_kit import House
from open_house import OpenHouse
from playwright.sync_api import Locator, Page, expect
from puppets import Puppet
from tablet_kit import LOOKS, STATION, Enter, assert_touchable
from variants import variants

from dray.messages import (
    Refusal,
    Role,
    Transport,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportState,
    TransportWait,
)
from dray.messages.fact import BidRefused, TaskOpened, TransportProgressed
from dray.plant import load_plant

from heartbeats import events  # isort: skip - their folder is on the path since `puppets` is

PLANT = load_plant("single-track")

Screenshot = Callable[..., Path]

VIEWS = {
    **LOOKS,
    "phone-light-es": {
        "viewport": {"width": 390, "height": 844},
        "color_scheme": "light",
        "locale": "es-ES",
    },
    "phone-dark-en": {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark", "locale": "en-GB"},
}

WORDS = {
    "en": ("Bring 40", "taken", "on board", "here", "Call off", "called off"),
    "de": ("40 bringen", "übernommen", "an Bord", "da", "Abbestellen", "abbestellt"),
    "es": ("Traer 40", "tomado", "a bordo", "aquí", "Anular", "anulado"),
}
"""What the second touch says, the steps from the second on, and what calls off."""


def card_of(page: Page) -> Locator:
    return page.locator(".transport-call")


def tile(page: Page, way: int, item: str) -> Locator:
    """One thing to touch first; 0 to bring, 1 to take away."""
    return card_of(page).get_by_role("group").nth(way).locator(".call-tile", has_text=item)


def ordered(house: OpenHouse) -> list[TransportOrdered]:
    """What the station was asked, each once."""

    async def sent(inside: House) -> list[TransportOrdered]:
        return list({each.transport: each for each in inside.bus.sent_to(STATION, TransportOrdered)}.values())

    return house.do(sent)


def tell(house: OpenHouse, call: TransportOrdered, number: int, state: TransportState, **fields: Any) -> None:
    """The station says how far it is, in its numbered facts."""
    usual = {"item": call.item, "quantity": call.quantity, "source": call.source, "destination": STATION}

    async def say(inside: House) -> None:
        fact = TransportProgressed(call.transport, state, **usual | fields)
        await inside.say(events(STATION, fact, first=number))

    house.do(say)


def offered_in_vain(house: OpenHouse, call: TransportOrdered) -> None:
    """The station gives it out, and a vehicle says why it does not bid."""
    task = f"{call.transport}-1"
    work = Transport(call.item, call.quantity, (call.source,), STATION, "tote")
    opened = TaskOpened(task, 1, Role.PRIMARY, 1, work, 20.0, 900.0, 105.0)
    waiting = TransportProgressed(
        call.transport,
        TransportState.WAITING,
        call.item,
        call.quantity,
        call.source,
        STATION,
        task=task,
        wait=TransportWait.NO_BID,
    )
    refused = BidRefused(task=task, epoch=1, role=Role.PRIMARY, reason=Refusal.NO_WAY)

    async def say(inside: House) -> None:
        await inside.say(events(STATION, opened, waiting))
        await inside.say(events("ATV2", refused, first=900))

    house.do(say)


@pytest.mark.parametrize("look", variants(VIEWS, "lying-light-en", "upright-dark-de", "phone-light-es"))
def test_two_touches_bring_it_and_each_step_is_told(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    amount, *steps, off, _ = WORDS[look.rpartition("-")[2]]
    page = enter(**VIEWS[look])
    tile(page, 0, "38").tap()
    card = card_of(page)
    second = card.locator(".call-amounts button").first
    expect(second).to_have_text(amount)
    assert ordered(house) == []
    assert_touchable(tile(page, 0, "38"), second)
    card.scroll_into_view_if_needed()
    screenshot(page, f"calling-{look}")

    second.tap()
    job = card.locator(".call-jobs > li").first
    expect(job).to_be_visible()
    [call] = ordered(house)
    assert (call.item, call.quantity) == ("shaft", 40)
    offered_in_vain(house, call)
    expect(job.locator(".tone-warn")).to_be_visible()
    expect(job.locator(".call-unwilling")).to_contain_text("ATV2")
    job.scroll_into_view_if_needed()
    screenshot(page, f"calling-unwilling-{look}")
    tell(house, call, 3, TransportState.ASSIGNED, carrier="ATV2", expected_s=600.0)
    expect(job.locator("[aria-current=step]")).to_have_text(steps[0])
    expect(job).to_contain_text("ATV2")
    expect(job.get_by_role("button", name=off)).to_be_visible()
    tell(house, call, 4, TransportState.ON_BOARD, carrier="ATV2", expected_s=600.0)
    expect(job.locator("[aria-current=step]")).to_have_text(steps[1])
    expect(job.get_by_role("button", name=off)).to_have_count(0)
    card.scroll_into_view_if_needed()
    screenshot(page, f"called-{look}")
    tell(house, call, 5, TransportState.DELIVERED)
    expect(job.locator("[aria-current=step]")).to_have_text(steps[2])
    assert ordered(house) == [call]


@pytest.mark.parametrize("look", variants(LOOKS, "lying-light-en"))
def test_what_is_taken_away_begins_here_and_can_be_called_off(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, look: str
) -> None:
    *_, off, was_off = WORDS[look.rpartition("-")[2]]
    page = enter(**VIEWS[look])
    tile(page, 1, "38").tap()
    card_of(page).locator(".call-amounts button").first.tap()
    job = card_of(page).locator(".call-jobs > li").first
    # It goes away: its last step is not here.
    there = {"en": "there", "de": "dort", "es": "allí"}[look.rpartition("-")[2]]
    expect(job.locator(".call-steps li").last).to_have_text(there)
    job.get_by_role("button", name=off).tap()
    expect(job.get_by_role("button", name=off)).to_have_count(0)

    async def called_off(inside: House) -> None:
        place = next(each for each in PLANT.storages if inside.bus.sent_to(each, TransportCancelled))
        asked = inside.bus.sent_to(place, TransportOrdered)[0]
        assert (asked.source, asked.item) == (STATION, "shaft")
        answer = TransportAnswered(asked.transport, TransportState.CANCELLED)
        inside.bus.tell(place, "gateway", answer)

    house.do(called_off)
    expect(job).to_contain_text(was_off)


def test_who_works_at_no_station_is_told_to_choose_a_machine(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter(station="")
    expect(page.get_by_role("region", name="Material")).to_contain_text("brought there")
    expect(card_of(page)).to_have_count(0)


def test_no_more_is_taken_away_than_is_there(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    tile(page, 1, "38").tap()
    expect(card_of(page).locator(".call-amounts button").first).to_have_text("Take 38 away")
