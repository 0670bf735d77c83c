"""Words of people to the station of a storage over REST: passed on with a grant, refused elsewhere, and told when its body is people."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from gateway_kit import AUTHORITY, House
from heartbeats import station_heartbeat

from dray.adapters.security.signing import TrustedKeys
from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    MachineCommand,
    Message,
    PeopleAsBody,
    UnconfirmedLoad,
    signed_words,
)

pytestmark = pytest.mark.anyio

ARRIVED = {"kind": "arrived", "item": "shaft", "quantity": 12, "vehicle": "ATV3"}


async def ask(house: House, body: dict[str, Any], station: str = "S1") -> httpx.Response:
    return await house.client.post(f"/api/stations/{station}/commands", json=body)


def obedient(house: House, refused: CommandRefusal | None = None) -> list[MachineCommand]:
    """S1 takes what it is told, or refuses it."""
    heard: list[MachineCommand] = []

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, MachineCommand):
            heard.append(message)
            answer = CommandAnswered(message.command, refused is None, refused, "12" if refused else "")
            house.bus.tell("S1", sender, answer)

    house.bus.join("S1", receive)
    return heard


async def test_a_word_is_passed_on_with_a_grant_and_answered(house: House) -> None:
    heard = obedient(house)
    answer = await ask(house, ARRIVED)
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    [said] = heard
    assert (said.kind.value, said.item, said.quantity, said.vehicle) == ("arrived", "shaft", 12, "ATV3")
    assert said.grant is not None
    assert TrustedKeys(AUTHORITY.public)(signed_words("S1", said, said.grant), said.grant.signature)


async def test_a_number_that_is_not_believed_is_told_with_the_expected_one(house: House) -> None:
    obedient(house, CommandRefusal.UNLIKELY)
    told = (await ask(house, ARRIVED | {"quantity": 120})).json()
    assert (told["done"], told["reason"], told["detail"]) == (False, "unlikely", "12")


@pytest.mark.parametrize(
    "body",
    [
        {"kind": "made", "item": "shaft", "quantity": 1},
        {"kind": "take_out"},
        {"kind": "arrived", "quantity": 1},
        {"kind": "arrived", "item": "", "quantity": 1},
        {"kind": "arrived", "item": "shaft"},
        {"kind": "arrived", "item": "shaft", "quantity": -1},
        {"kind": "arrived", "item": "shaft", "quantity": 1.5},
        {"kind": "stock_is", "item": "shaft", "quantity": 1, "vehicle": "ATV3"},
        {"kind": "arrived", "item": "shaft", "quantity": 1, "more": 1},
    ],
)
async def test_what_no_station_can_be_told_is_not_sent(house: House, body: dict[str, Any]) -> None:
    heard = obedient(house)
    assert (await ask(house, body)).status_code == 422
    assert heard == []


async def test_a_machine_and_nobody_are_no_stations(house: House) -> None:
    for name in ("M1", "S99"):
        assert (await ask(house, ARRIVED, name)).status_code == 404


async def test_loads_that_wait_for_a_word_are_told_where_the_body_is_people(house: House) -> None:
    house.projection.fold(station_heartbeat("S1"))
    view = house.projection.stations.view("S1")
    assert view is not None
    assert view.unconfirmed is None
    load = UnconfirmedLoad("ATV3", "shaft", 12, goes=True)
    house.projection.fold(station_heartbeat("S1", 2, people=PeopleAsBody(loads=(load,))))
    view = house.projection.stations.view("S1")
    assert view is not None
    assert view.unconfirmed is not None
    [told] = view.unconfirmed
    assert (told.vehicle, told.item, told.quantity, told.goes) == ("ATV3", "shaft", 12, True)
