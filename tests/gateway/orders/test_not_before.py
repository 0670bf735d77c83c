"""Plain transports that are not to begin yet: no place hears of them before their time, whatever happens meanwhile."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest
from answers import problem
from gateway_kit import House, gateway
from heartbeats import atv_heartbeat, events
from wall_clock import NOW_S

from dray.gateway.access.principal import Scope
from dray.gateway.http.provided import provided
from dray.gateway.orders.transport_draft import WISH_S
from dray.gateway.orders.transports import PlainTransports
from dray.messages import TransportAnswered, TransportCancelled, TransportOrdered, TransportState
from dray.messages.fact import TransportProgressed
from dray.priorities import TRANSPORT_WITHIN_S, Priority

pytestmark = pytest.mark.anyio

PATH = "/api/transports"
BEGIN_S = NOW_S + 1000.0


def moment(at_s: float) -> str:
    return datetime.fromtimestamp(at_s, UTC).isoformat()


DRAFT = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 40, "not_before": moment(BEGIN_S)}


async def called(house: House, **fields: Any) -> dict[str, Any]:
    response = await house.client.post(PATH, json=DRAFT | fields)
    assert response.status_code == 201, response.text
    answer: dict[str, Any] = response.json()
    return answer


async def look(house: House, wall_s: float) -> None:
    """Let time pass, and the gateway look at what it holds."""
    house.wall.now_s = wall_s
    await provided(house.app, PlainTransports).begin_due()


def asked(house: House) -> list[str]:
    return [each.transport for each in house.bus.sent_to("M8", TransportOrdered)]


async def test_its_place_hears_of_it_when_its_time_has_come(house: House) -> None:
    answer = await called(house)
    name = answer["id"]
    assert (answer["status"], answer["wait"]) == ("waiting", "not_before")
    assert datetime.fromisoformat(answer["not_before"]).timestamp() == BEGIN_S
    await look(house, BEGIN_S - 0.5)
    assert asked(house) == []
    await look(house, BEGIN_S)
    assert asked(house) == [name]
    assert (await house.get(f"{PATH}/{name}"))["wait"] is None
    await house.say(
        events("M8", TransportProgressed(name, TransportState.DELIVERED, "shaft", 40, "S3", "M8"))
    )
    assert (await house.get(f"{PATH}/{name}"))["status"] == "delivered"


async def test_it_begins_by_itself(house: House) -> None:
    name = (await called(house))["id"]
    house.wall.now_s = BEGIN_S
    again = await house.client.post(PATH, json={**DRAFT, "not_before": None})
    assert again.status_code == 201  # It wakes who looks.
    await house.bus.next_to("M8", TransportOrdered, after=1)
    assert set(asked(house)) == {name, again.json()["id"]}


async def test_priority_and_wish_count_from_then(url: str) -> None:
    async with gateway(url, speed=10.0) as house:
        await house.say([atv_heartbeat("ATV3", 1)])
        answer = await called(house, priority="urgent", vehicle="ATV3", vehicle_only=False)
        due, until = (
            datetime.fromisoformat(answer[each]).timestamp() for each in ("due_at", "vehicle_until")
        )
        assert due - BEGIN_S == pytest.approx(TRANSPORT_WITHIN_S[Priority.URGENT] / 10.0, abs=0.01)
        assert until - BEGIN_S == pytest.approx(WISH_S / 10.0, abs=0.01)
        assert answer["vehicle_waits"] is None
        assert (await house.get(f"{PATH}/{answer['id']}"))["vehicle_waits"] is None


async def test_a_key_is_not_sooner_by_a_later_begin(house: House) -> None:
    _, header = await house.key(Scope.TRANSPORTS_CALL)
    soon = DRAFT | {"due_at": moment(BEGIN_S + 60.0)}
    body = problem(await house.visitor(**header).post(PATH, json=soon), 403, "beyond-key")
    assert [each["field"] for each in body["errors"]] == ["due_at"]


async def test_what_is_called_off_before_its_time_has_ended_and_no_place_hears_of_it(house: House) -> None:
    name = (await called(house))["id"]
    answer = (await house.client.post(f"{PATH}/{name}/cancel")).json()
    assert (answer["status"], answer["wait"], answer["ended_at"] is None) == ("cancelled", None, False)
    await look(house, BEGIN_S)
    assert asked(house) == []
    assert house.bus.sent_to("M8", TransportCancelled) == []
    assert (await house.client.post(f"{PATH}/{name}/cancel")).status_code == 200


async def test_the_next_life_goes_on_holding_it(url: str) -> None:
    async with gateway(url) as house:
        name = (await called(house))["id"]
    async with gateway(url, incarnation=2) as house:
        assert asked(house) == []
        await look(house, BEGIN_S)
        assert asked(house) == [name]
    async with gateway(url, incarnation=3) as house:
        # It was begun: a clock that is set back does not hold it again.
        assert asked(house) == [name]


async def test_a_life_that_comes_after_its_time_begins_it(url: str) -> None:
    async with gateway(url) as house:
        name = (await called(house))["id"]
    async with gateway(url, incarnation=2) as house:
        await look(house, BEGIN_S + 3600.0)
        assert asked(house) == [name]


async def test_of_two_gateways_one_calls_off_and_the_other_does_not_begin_it(url: str) -> None:
    async with gateway(url) as one, gateway(url, incarnation=2) as other:
        name = (await called(one))["id"]
        await provided(other.app, PlainTransports).start()
        assert (await other.client.post(f"{PATH}/{name}/cancel")).json()["status"] == "cancelled"
        await look(one, BEGIN_S)
        await look(other, BEGIN_S)
        assert asked(one) == asked(other) == []


async def test_of_two_gateways_one_begins_and_the_other_calls_off_by_the_factory(url: str) -> None:
    async with gateway(url) as one, gateway(url, incarnation=2) as other:
        name = (await called(one))["id"]
        await provided(other.app, PlainTransports).start()
        await look(one, BEGIN_S)
        answer = (await other.client.post(f"{PATH}/{name}/cancel")).json()
        assert (answer["status"], answer["cancel_at"] is None) == ("waiting", False)
        assert other.bus.sent_to("M8", TransportCancelled) == [TransportCancelled(name)]
        other.bus.tell("M8", "gateway", TransportAnswered(name, TransportState.CANCELLED))


async def test_one_that_is_past_means_at_once(house: House) -> None:
    answer = await called(house, not_before=moment(NOW_S - 60.0))
    assert (answer["wait"], asked(house)) == (None, [answer["id"]])


async def test_recurring_work_begins_at_its_own_moments(house: House) -> None:
    schedule = {"name": "Shafts", "calendar": "0 6 * * *", "time_zone": "Europe/Berlin", "transport": DRAFT}
    refused = await house.client.post("/api/schedules", json=schedule)
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "transport")
