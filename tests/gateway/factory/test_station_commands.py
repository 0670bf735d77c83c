"""Words of people to the station of a storage over REST: passed on with a grant, refused elsewhere, and told when its body is people."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from answers import problem
from areas_kit import AREAS
from gateway_kit import AUTHORITY, House
from heartbeats import station_heartbeat
from obedient_places import obedient
from wall_clock import NOW_S

from dray.adapters.security.signing import TrustedKeys
from dray.gateway.access.principal import Role
from dray.gateway.factory.commands import WORDS_TRIES
from dray.gateway.live.views import AlertView
from dray.gateway.live.visibility import AreaVisibility
from dray.messages import (
    CommandRefusal,
    PeopleAsBody,
    UnconfirmedLoad,
    signed_words,
)
from dray.messages.keys import GATE

pytestmark = pytest.mark.anyio

AT_GATE, ELSEWHERE = "AREA1", "AREA2"
"""Where the delivery warehouse of the plant lies, and S1; where neither does."""

ARRIVED = {"kind": "arrived", "item": "shaft", "quantity": 12, "vehicle": "ATV3"}


async def ask(house: House, body: dict[str, Any], station: str = "S1") -> httpx.Response:
    return await house.client.post(f"/api/stations/{station}/commands", json=body)


async def test_a_word_is_passed_on_with_a_grant_and_answered(house: House) -> None:
    heard = obedient(house, "S1")
    answer = await ask(house, ARRIVED)
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    [said] = heard
    assert (said.kind.value, said.item, said.quantity, said.vehicle) == ("arrived", "shaft", 12, "ATV3")
    assert said.grant is not None
    assert TrustedKeys(AUTHORITY.public)(signed_words("S1", said, said.grant), said.grant.signature)


async def test_a_number_that_is_not_believed_is_told_with_the_expected_one(house: House) -> None:
    obedient(house, "S1", refusal=CommandRefusal.UNLIKELY, detail="12")
    told = (await ask(house, ARRIVED | {"quantity": 120})).json()
    assert (told["done"], told["reason"], told["detail"]) == (False, "unlikely", "12")


@pytest.mark.parametrize(
    ("body", "node"), [({"kind": "fetch_goods", "node": "b2"}, "b2"), ({"kind": "write_off"}, "")]
)
async def test_what_becomes_of_a_thing_on_board_of_a_failed_vehicle_is_passed_on(
    house: House, body: dict[str, Any], node: str
) -> None:
    heard = obedient(house, "S1")
    answer = await ask(house, body | {"task": "T-9-1"})
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    [said] = heard
    assert (said.kind.value, said.task, said.node, said.item, said.quantity) == (
        body["kind"],
        "T-9-1",
        node,
        "",
        0,
    )


@pytest.mark.parametrize(
    "body",
    [
        {"kind": "fetch_goods"},
        {"kind": "write_off", "task": "T-9-1", "node": "b2"},
        {"kind": "write_off", "task": "T-9-1", "item": "shaft"},
        {"kind": "write_off", "task": "T-9-1", "item": "shaft", "quantity": 1},
        {"kind": "arrived", "item": "shaft", "quantity": 1, "task": "T-9-1"},
        {"kind": "arrived", "item": "shaft", "quantity": 1, "node": "b2"},
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
    heard = obedient(house, "S1")
    assert (await ask(house, body)).status_code == 422
    assert heard == []


async def test_a_machine_and_nobody_are_no_stations(house: House) -> None:
    for name in ("M1", "S99"):
        assert (await ask(house, ARRIVED, name)).status_code == 404


@pytest.mark.parametrize(
    ("area", "station", "status"),
    [
        (AT_GATE, "S1", 200),
        (AT_GATE, GATE, 200),
        (AT_GATE, "S2", 403),
        (ELSEWHERE, "S2", 200),
        (ELSEWHERE, "S1", 403),
        (ELSEWHERE, GATE, 403),
        # Not even that there is none is told to who is limited to areas.
        (AT_GATE, "S99", 403),
        (ELSEWHERE, "S99", 403),
        (AT_GATE, "M1", 403),
    ],
)
async def test_an_operator_says_what_has_happened_in_its_own_area_alone(
    house: House, area: str, station: str, status: int
) -> None:
    heard = obedient(house, station)
    client = await house.log_in("operator", Role.OPERATOR, area)
    answer = await client.post(f"/api/stations/{station}/commands", json=ARRIVED)
    assert answer.status_code == status, answer.text
    areas = [said.grant and said.grant.areas for said in heard]
    assert areas == ([(area,)] if status == 200 else [])


@pytest.mark.parametrize("station", ["S1", GATE])
async def test_a_station_that_is_shut_out_is_told_nothing(house: House, station: str) -> None:
    heard = obedient(house, station)
    assert (
        await house.client.post(f"/api/agents/{station}/shut-out", json={"reason": "odd"})
    ).status_code == 200
    operator = await house.log_in("operator", Role.OPERATOR, AT_GATE)
    for client in (operator, house.client):
        answer = await client.post(f"/api/stations/{station}/commands", json=ARRIVED)
        problem(answer, 409, "shut-out")
    assert heard == []


async def test_a_word_to_the_gate_is_shown_where_a_delivery_warehouse_lies_and_nowhere_else(
    house: House,
) -> None:
    obedient(house, GATE)
    assert (await ask(house, ARRIVED, GATE)).status_code == 200
    both = await house.log_in("both", Role.OPERATOR, AT_GATE, ELSEWHERE)
    assert (await both.post(f"/api/stations/{GATE}/commands", json=ARRIVED)).status_code == 200
    views = house.projection.commands.views()
    assert [view.by for view in views] == ["Administrator", "Both"]
    for view in views:
        sees = {area for area in AREAS if AreaVisibility(house.projection, frozenset({area})).command(view)}
        assert sees == {AT_GATE}


async def test_the_gate_is_seen_and_is_missed_where_a_delivery_warehouse_lies_and_nowhere_else(
    house: House,
) -> None:
    views = {area: AreaVisibility(house.projection, frozenset({area})) for area in AREAS}
    house.projection.fold(station_heartbeat(GATE))
    gate = house.projection.stations.view(GATE)
    assert gate is not None
    assert all(view.station(gate) is None for view in views.values()), (
        "its controller counts, and nobody else"
    )
    house.projection.fold(station_heartbeat(GATE, 2, people=PeopleAsBody()))
    gate = house.projection.stations.view(GATE)
    assert gate is not None
    assert {area for area, view in views.items() if view.station(gate)} == {AT_GATE}
    house.projection.fold(station_heartbeat(GATE, 3, problem="its controller is not heard: cut"))
    gate = house.projection.stations.view(GATE)
    assert gate is not None
    seen = {area: station for area, view in views.items() if (station := view.station(gate))}
    assert {area: station.problem for area, station in seen.items()} == {
        AT_GATE: "its controller is not heard: cut"
    }
    lost = AlertView(
        id="gate_lost-gate",
        kind="gate_lost",
        level="alarm",
        response="look_at_gate",
        agent=GATE,
        since_at_s=NOW_S,
    )
    assert {area for area, view in views.items() if view.alert(lost)} == {AT_GATE}


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


async def test_nobody_says_more_words_to_a_place_than_anybody_can_count(house: House) -> None:
    heard = obedient(house, "S1")
    for number in range(WORDS_TRIES):
        assert (await ask(house, ARRIVED | {"command": f"word-{number}"})).status_code == 200
    refused = await ask(house, ARRIVED | {"command": "one-more"})
    problem(refused, 429, "too-many-tries")
    assert refused.headers["Retry-After"] == "1"
    assert len(heard) == WORDS_TRIES
    # What was said before may be asked for again, and others are not held up by it.
    assert (await ask(house, ARRIVED | {"command": "word-7"})).status_code == 200
    other = await house.log_in("maria")
    assert (await other.post("/api/stations/S1/commands", json=ARRIVED)).status_code == 200
    house.wall.now_s += 60
    assert (await ask(house, ARRIVED | {"command": "one-more"})).status_code == 200
