"""Plain transports over REST: on disk before they are answered, asked of the place to which they go, and followed to their end."""

from __future__ import annotations

import asyncio
import re
from datetime import datetime
from typing import Any

import msgspec
import pytest
from fake_bus import PLANT
from gateway_kit import House, gateway
from heartbeats import atv_heartbeat, events, station_heartbeat

from dray.gateway.access.principal import Role, Scope
from dray.gateway.access.rules import RULES
from dray.gateway.orders.transport_draft import WISH_S
from dray.gateway.orders.transports import loads_text
from dray.messages import (
    THING,
    AtvStatus,
    Phase,
    Reason,
    Refusal,
    StationHeartbeat,
    StockLevel,
    Transport,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportRefusal,
    TransportState,
)
from dray.messages import Role as Part
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    BidRefused,
    CarrierChanged,
    PhaseEntered,
    TaskClosed,
    TaskOpened,
    TransportProgressed,
)
from dray.protocol.contract_net.auction_rules import PATIENCE_S

pytestmark = pytest.mark.anyio

PATH = "/api/transports"
DRAFT = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 40}


async def called(house: House, **fields: Any) -> dict[str, Any]:
    response = await house.client.post(PATH, json=DRAFT | fields)
    assert response.status_code == 201, response.text
    answer: dict[str, Any] = response.json()
    return answer


async def settled(house: House, name: str, status: str) -> dict[str, Any]:
    """It, once it has this status."""
    for _ in range(200):
        answer: dict[str, Any] = await house.get(f"{PATH}/{name}")
        if answer["status"] == status:
            return answer
        await asyncio.sleep(0)
    pytest.fail(f"{name} is {answer['status']}, and not {status}")


def progress(name: str, state: TransportState, **fields: Any) -> TransportProgressed:
    usual = {"item": "shaft", "quantity": 40, "source": "S3", "destination": "M8"}
    return TransportProgressed(name, state, **usual | fields)


async def test_it_is_asked_of_the_place_to_which_it_goes(house: House) -> None:
    answer = await called(house, priority="urgent", vehicle=None)
    assert (answer["status"], answer["from"], answer["to"]) == ("waiting", "S3", "M8")
    [asked] = house.bus.sent_to("M8", TransportOrdered)
    assert (asked.transport, asked.source, asked.item, asked.quantity) == (answer["id"], "S3", "shaft", 40)
    assert asked.due_s == pytest.approx(60.0)
    assert await house.get(f"{PATH}/{answer['id']}") == answer
    assert (await house.get(PATH))["items"] == [answer]
    line = (await house.audit())[0]
    assert (line.action, line.target) == ("transport.call", answer["id"])


async def test_the_same_key_is_one_transport(house: House) -> None:
    key = {"Idempotency-Key": "button-8-1"}
    first = await house.client.post(PATH, json=DRAFT, headers=key)
    again = await house.client.post(PATH, json=DRAFT, headers=key)
    assert (again.status_code, again.content) == (201, first.content)
    assert again.headers["Idempotency-Replayed"] == "true"
    assert len((await house.get(PATH))["items"]) == 1
    other = await house.client.post(PATH, json=DRAFT | {"quantity": 5}, headers=key)
    assert other.status_code == 422


async def test_what_its_place_tells_is_shown_and_an_end_stays(house: House) -> None:
    name = (await called(house))["id"]
    told = (
        progress(name, TransportState.WAITING, wait="short"),
        progress(name, TransportState.ASSIGNED, carrier="ATV6", expected_s=90.0, task=f"{name}-1"),
        progress(name, TransportState.DELIVERED),
        progress(name, TransportState.WAITING),
    )
    first, second, *last = events("M8", *told)
    await house.say([first])
    assert (await house.get(f"{PATH}/{name}"))["wait"] == "short"
    await house.say([second])
    answer = await house.get(f"{PATH}/{name}")
    assert (answer["status"], answer["carrier"], answer["task"]) == ("assigned", "ATV6", f"{name}-1")
    await house.say([*last, first])
    answer = await house.get(f"{PATH}/{name}")
    assert (answer["status"], answer["carrier"], answer["ended_at"] is None) == ("delivered", None, False)


async def test_nobody_else_tells_how_it_is(house: House) -> None:
    name = (await called(house))["id"]
    await house.say(events("M9", progress(name, TransportState.DELIVERED)))
    house.bus.tell("M9", "gateway", TransportAnswered(name, TransportState.DELIVERED))
    assert (await house.get(f"{PATH}/{name}"))["status"] == "waiting"


async def test_the_places_answer_ends_it_too_with_the_reason(house: House) -> None:
    name = (await called(house))["id"]
    refused = TransportAnswered(name, TransportState.CANCELLED, TransportRefusal.NOT_KEPT_HERE)
    house.bus.tell("M8", "gateway", refused)
    assert (await settled(house, name, "cancelled"))["refused"] == "not_kept_here"


async def test_it_is_called_off_until_it_is_on_board(house: House) -> None:
    name = (await called(house))["id"]
    house.bus.tell("M8", "gateway", TransportAnswered(name, TransportState.WAITING))
    answer = await house.client.post(f"{PATH}/{name}/cancel")
    assert (answer.status_code, answer.json()["status"], bool(answer.json()["cancel_at"])) == (
        200,
        "waiting",
        True,
    )
    assert house.bus.sent_to("M8", TransportCancelled) == [TransportCancelled(name)]
    house.bus.tell("M8", "gateway", TransportAnswered(name, TransportState.CANCELLED))
    await settled(house, name, "cancelled")
    assert (await house.client.post(f"{PATH}/{name}/cancel")).status_code == 200
    late = (await called(house))["id"]
    await house.say(events("M8", progress(late, TransportState.ON_BOARD), first=50))
    refused = await house.client.post(f"{PATH}/{late}/cancel")
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:dray:problem:transport-on-its-way")


async def test_a_gateway_that_starts_again_asks_for_what_is_open(url: str) -> None:
    async with gateway(url) as house:
        name, off = (await called(house))["id"], (await called(house))["id"]
        await house.client.post(f"{PATH}/{off}/cancel")
    async with gateway(url, incarnation=2) as house:
        assert [asked.transport for asked in house.bus.sent_to("M8", TransportOrdered)] == [name]
        assert house.bus.sent_to("M8", TransportCancelled) == [TransportCancelled(off)]


@pytest.mark.parametrize(
    ("fields", "field"),
    [
        ({"item": "gold"}, "item"),
        ({"item": "gear-unit-g1"}, "item"),
        ({"from": "S2"}, "from"),
        ({"to": "M10"}, "to"),
        ({"to": "S3"}, "to"),
        ({"quantity": 41}, "quantity"),
        ({"quantity": 0}, "quantity"),
        ({"vehicle": "ATV99"}, "vehicle"),
        ({"ability": "crane"}, "ability"),
        ({"due_at": "2001-01-01T00:00:00Z"}, "due_at"),
        ({"due_at": "2030-03-18T00:00:00Z", "not_before": "2030-03-18T00:00:00Z"}, "not_before"),
        ({"not_before": "2030-03-18T00:00:00"}, "not_before"),
        ({"colour": "red"}, "colour"),
    ],
)
async def test_what_cannot_be_is_refused_with_the_field(
    house: House, fields: dict[str, Any], field: str
) -> None:
    answer = await house.client.post(PATH, json=DRAFT | fields)
    assert answer.status_code == 422
    assert [error["field"] for error in answer.json()["errors"]] == [field]


async def test_words_are_looked_for_in_places_materials_vehicles_and_callers(house: House) -> None:
    await house.say([atv_heartbeat("ATV3", 1)])
    one = await called(house, vehicle="ATV3")
    other = await called(house, **{"from": "S1", "to": "M7", "item": "housing", "quantity": 4})

    async def found(words: str) -> list[str]:
        return [each["id"] for each in (await house.get(PATH, q=words))["items"]]

    shaft = next(each.name for each in PLANT.materials if each.id == "shaft")
    for words in (one["id"].lower(), "atv3", "m8", f"{shaft[:4].upper()} m8"):
        assert await found(words) == [one["id"]], words
    assert set(await found("s3")) >= {one["id"]}
    assert await found("housing") == [other["id"]]
    assert await found("housing m8") == []
    assert await found("100%") == []
    assert await found("_") == []


async def test_an_ability_is_wanted_beside_what_the_load_asks_for(house: House) -> None:
    answer = await called(house, ability="pallet")
    [asked] = house.bus.sent_to("M8", TransportOrdered)
    assert (answer["ability"], asked.ability) == ("pallet", "pallet")
    assert (await house.get(f"{PATH}/{answer['id']}"))["ability"] == "pallet"
    refused = await house.client.post(PATH, json=DRAFT | {"ability": "crane"})
    assert "they have pallet, tote" in refused.json()["detail"]
    light = next(each.id for each in PLANT.fleet if each.type == "light")
    await house.say([atv_heartbeat(light, 1)])
    unfit = await house.client.post(PATH, json=DRAFT | {"ability": "pallet", "vehicle": light})
    assert unfit.json()["errors"] == [
        {
            "field": "vehicle",
            "reason": f"{light} cannot carry this: it lacks pallet",
            "code": "vehicle_lacks",
            "values": {"vehicle": light, "abilities": "pallet"},
        }
    ]


async def test_a_key_may_call_and_nothing_else_and_sees_its_own(house: House) -> None:
    others = (await called(house))["id"]
    _, button = await house.key(Scope.TRANSPORTS_CALL)
    visitor = house.visitor(**button)
    own = (await visitor.post(PATH, json=DRAFT)).json()["id"]
    assert [each["id"] for each in (await visitor.get(PATH)).json()["items"]] == [own]
    assert (await visitor.get(f"{PATH}/{others}")).status_code == 404
    assert (await visitor.post(f"{PATH}/{others}/cancel")).status_code == 404
    assert (await visitor.get("/api/orders")).status_code == 403
    assert (await visitor.post(f"{PATH}/{own}/cancel")).status_code == 200


@pytest.mark.parametrize("place", ["", "M8"])
async def test_a_call_button_is_refused_everywhere_else(house: House, place: str) -> None:
    _, button = await house.key(Scope.TRANSPORTS_CALL, **({"places": place} if place else {}))
    visitor = house.visitor(**button)
    refused = {}
    for (method, route), rule in RULES.items():
        if rule.scope in (None, Scope.TRANSPORTS_CALL):
            continue
        answer = await visitor.request(method, re.sub(r"{\w+}", "x-1", route), json={})
        if answer.status_code != 403:
            refused[method, route] = answer.status_code
    assert not refused
    assert sum(rule.scope is Scope.TRANSPORTS_CALL for rule in RULES.values()) == 5


async def test_an_operator_calls_for_the_own_area(house: House) -> None:
    plant = house.projection.site.plant
    area = next(area for area in plant.areas if area in plant.areas_near(*plant.position_of("M8"), 0.0))
    elsewhere = next(
        each for each in plant.areas if each not in plant.areas_near(*plant.position_of("M8"), 0.0)
    )
    near = await house.log_in("anna", Role.OPERATOR, area)
    assert (await near.post(PATH, json=DRAFT, headers={"Origin": "http://dray.test"})).status_code == 201
    far = await house.log_in("bert", Role.OPERATOR, elsewhere)
    answer = await far.post(PATH, json=DRAFT | {"from": "S1"}, headers={"Origin": "http://dray.test"})
    keeps = plant.areas_near(*plant.position_of("S1"), 0.0)
    assert answer.status_code == (201 if elsewhere in keeps else 422)


@pytest.mark.parametrize(
    ("told", "why"),
    [
        ({}, None),
        ({"status": AtvStatus.ERROR}, "error"),
        ({"status": AtvStatus.STOPPED}, "stopped"),
        ({"battery_frac": 0.02}, "battery"),
    ],
)
async def test_what_the_wanted_vehicle_says_of_itself_is_why_it_waits(
    house: House, told: dict[str, Any], why: str | None
) -> None:
    await house.say([atv_heartbeat("ATV3", 1)])
    name = (await called(house, vehicle="ATV3"))["id"]
    await house.say([atv_heartbeat("ATV3", 2, **told)])
    assert (await house.get(f"{PATH}/{name}"))["vehicle_waits"] == why
    assert [each["vehicle_waits"] for each in (await house.get(PATH))["items"]] == [why]
    house.wall.now_s += 3600.0
    assert (await house.get(f"{PATH}/{name}"))["vehicle_waits"] == "silent"


async def test_why_the_wanted_vehicle_has_not_bid_is_told_until_somebody_carries(house: House) -> None:
    await house.say([atv_heartbeat("ATV3", 1)])
    name = (await called(house, vehicle="ATV3"))["id"]
    task, work = f"{name}-1", Transport("shaft", 40, ("S3",), "M8", "tote", vehicle="ATV3")
    refused = BidRefused(task=task, epoch=1, role=Part.PRIMARY, reason=Refusal.NO_WAY)
    waiting = progress(name, TransportState.WAITING, wait="no_bid", task=task)
    await house.say(events("M8", TaskOpened(task, 1, Part.PRIMARY, 1, work, 20.0, 900.0, 105.0), waiting))
    await house.say(events("ATV3", refused))
    assert (await house.get(f"{PATH}/{name}"))["vehicle_waits"] == "no_way"
    carried = progress(name, TransportState.ASSIGNED, carrier="ATV3", task=task)
    await house.say(events("M8", carried, first=10))
    assert (await house.get(f"{PATH}/{name}"))["vehicle_waits"] is None


@pytest.mark.parametrize(("only", "until_s"), [(True, None), (False, WISH_S)])
async def test_a_wish_for_a_vehicle_ends_and_an_order_for_it_does_not(
    url: str, only: bool, until_s: float | None
) -> None:
    async with gateway(url, speed=10.0) as house:
        await house.say([atv_heartbeat("ATV3", 1)])
        answer = await called(house, vehicle="ATV3", vehicle_only=only)
        [asked] = house.bus.sent_to("M8", TransportOrdered)
        assert (asked.vehicle, asked.vehicle_until_s) == ("ATV3", until_s and pytest.approx(until_s))
        until = answer["vehicle_until"]
        assert (until is None) == only
        if until is not None:
            assert datetime.fromisoformat(until).timestamp() == pytest.approx(
                house.wall.now_s + WISH_S / 10.0
            )
        house.wall.now_s += WISH_S
        # Nobody waits for that vehicle any more, so nobody asks why it does not come.
        waits = (await house.get(f"{PATH}/{answer['id']}"))["vehicle_waits"]
        assert waits == ("silent" if only else None)


async def test_what_priorities_mean_is_told_as_it_is_done(house: House) -> None:
    told = await house.get("/api/priorities")
    for priority, within_s in told["transports"].items():
        asked = (await house.client.post(PATH, json=DRAFT | {"priority": priority})).json()
        created, due = (datetime.fromisoformat(asked[each]) for each in ("created_at", "due_at"))
        assert (due - created).total_seconds() == pytest.approx(within_s, abs=0.01), priority
    assert list(told["transports"]) == list(told["orders"]) == ["urgent", "high", "normal", "low"]
    assert told["passed_most_s"] == PATIENCE_S


async def sorted_ones(house: House) -> list[str]:
    """Three, of which the one that was called for last is due first."""
    dues = ("2030-03-18T00:00:00Z", "2030-03-19T00:00:00Z", "2030-03-17T19:00:00Z")
    names = []
    for second, due in enumerate(dues):
        house.wall.now_s += second
        names.append((await called(house, due_at=due))["id"])
    return names


async def test_they_are_sorted_by_when_they_were_called_and_by_when_they_are_due(house: House) -> None:
    first, second, third = await sorted_ones(house)

    async def pages(**asked: Any) -> list[str]:
        found, cursor = [], None
        while True:
            page = await house.get(PATH, limit=2, **asked, **({"cursor": cursor} if cursor else {}))
            found += [each["id"] for each in page["items"]]
            if (cursor := page["next_cursor"]) is None:
                return found

    assert await pages() == [third, second, first]
    assert await pages(descending=False) == [first, second, third]
    assert await pages(sort="due", descending=False) == [third, first, second]
    assert await pages(sort="due") == [second, first, third]
    assert (await house.client.get(PATH, params={"sort": "colour"})).status_code == 422


async def test_all_of_them_come_as_a_table_in_the_same_order(house: House) -> None:
    first, second, third = await sorted_ones(house)
    answer = await house.client.get(PATH, params={"format": "csv", "sort": "due", "limit": 1})
    assert answer.headers["content-type"].startswith("text/csv")
    header, *lines = answer.text.splitlines()
    assert header.startswith("id,status,from,to,item,quantity,priority,")
    assert [line.split(",")[0] for line in lines] == [second, first, third]
    _, stranger = await house.key(Scope.TRANSPORTS_CALL)
    others = await house.visitor(**stranger).get(PATH, params={"format": "csv"})
    assert others.text.splitlines() == [header]


# --- its timeline -----------------------------------------------------------------------------------


def carried(name: str) -> list[tuple[str, AnyFact]]:
    """ATV6 wins and falls silent, ATV1 takes over and brings it."""
    work = Transport("shaft", 40, ("S3",), "M8", "tote")
    return [
        ("M8", TaskOpened(f"{name}-1", 1, Part.PRIMARY, 1, work, 20.0, 300.0, 5.0)),
        ("M8", AwardAnswered(f"{name}-1", 1, Part.SECONDARY, "ATV1", "accepted")),
        ("M8", AwardAnswered(f"{name}-1", 1, Part.PRIMARY, "ATV6", "accepted")),
        ("ATV6", PhaseEntered(f"{name}-1", 1, Phase.APPROACHING, "S3")),
        ("M8", CarrierChanged(f"{name}-1", 2, "ATV6", "ATV1", Reason.SILENT, 5.5)),
        ("ATV1", PhaseEntered(f"{name}-1", 2, Phase.APPROACHING, "S3")),
        ("ATV1", PhaseEntered(f"{name}-1", 2, Phase.CARRYING, "S3")),
        ("ATV1", PhaseEntered(f"{name}-1", 2, Phase.HANDING_OVER, "M8")),
        ("M8", TaskClosed(f"{name}-1", 2, "delivered", "ATV1", 45.0)),
        ("M8", progress(name, TransportState.DELIVERED)),
    ]


async def told(house: House, name: str) -> None:
    for number, (agent, fact) in enumerate(carried(name), 1):
        await house.say(events(agent, fact, first=number, at_s=10.0 * number))


async def test_its_timeline_tells_who_won_who_took_over_and_who_brought_it(house: House) -> None:
    name, other = (await called(house))["id"], (await called(house))["id"]
    before = await house.get(f"{PATH}/{name}/timeline")
    assert ([each["kind"] for each in before["moments"]], before["attempts"]) == (["called"], [])
    await told(house, name)
    story = await house.get(f"{PATH}/{name}/timeline")
    assert [(each["kind"], each["agent"]) for each in story["moments"]] == [
        ("called", "Administrator"),
        ("won", "ATV6"),
        ("took_over", "ATV1"),
        ("fetched", "ATV1"),
        ("handed_over", "ATV1"),
        ("delivered", ""),
    ]
    (attempt,) = story["attempts"]
    assert (attempt["source"], attempt["destination"], attempt["outcome"]) == ("S3", "M8", "delivered")
    assert [(leg["carrier"], leg["replaced"]) for leg in attempt["legs"]] == [
        ("ATV6", "silent"),
        ("ATV1", ""),
    ]
    assert story["is_whole"]
    assert (await house.get(f"{PATH}/{other}/timeline"))["attempts"] == []


async def test_its_timeline_still_tells_who_brought_it_when_the_log_has_forgotten(house: House) -> None:
    name = (await called(house))["id"]
    await told(house, name)
    async with house.store.write() as work:
        await work.events.forget(1, 1_000)
    story = await house.get(f"{PATH}/{name}/timeline")
    # Who had won before that is not known any more.
    assert [each["kind"] for each in story["moments"]] == ["called", "delivered"]
    (attempt,) = story["attempts"]
    assert [leg["carrier"] for leg in attempt["legs"]] == ["ATV1"]
    assert (attempt["outcome"], story["is_whole"]) == ("delivered", False)


async def test_who_won_it_is_still_told_where_nobody_has_taken_it_over(house: House) -> None:
    name = (await called(house))["id"]
    opened, _, won, *_ = carried(name)
    await house.say(events("M8", opened[1], won[1]))
    async with house.store.write() as work:
        await work.events.forget(1, 1_000)
    story = await house.get(f"{PATH}/{name}/timeline")
    assert [(each["kind"], each["agent"]) for each in story["moments"]][1:] == [("won", "ATV6")]


async def test_a_timeline_is_for_who_may_see_the_transport(house: House) -> None:
    name = (await called(house))["id"]
    _, stranger = await house.key(Scope.TRANSPORTS_CALL)
    answer = await house.visitor(**stranger).get(f"{PATH}/{name}/timeline")
    assert answer.status_code == 404
    assert (await house.client.get(f"{PATH}/T-1M9K3X2A4-0000/timeline")).status_code == 404


@pytest.mark.parametrize(
    ("pieces", "most", "told"), [(41, 40, "1 x 40 + 1"), (80, 40, "2 x 40"), (10_000, 3, "3333 x 3 + 1")]
)
def test_what_is_more_than_one_load_is_told_in_loads(pieces: int, most: int, told: str) -> None:
    assert loads_text(pieces, most) == told


async def test_more_than_one_load_is_refused_with_the_loads_that_would_be_taken(house: House) -> None:
    answer = await house.client.post(PATH, json=DRAFT | {"quantity": 100})
    [error] = answer.json()["errors"]
    assert (error["field"], error["code"]) == ("quantity", "load_too_large")
    assert error["values"] == {"item": "shaft", "most": "40", "loads": "2 x 40 + 20"}
    assert "ask for several transports: 2 x 40 + 20" in error["reason"]


async def test_what_no_vehicle_of_the_fleet_carries_is_refused(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant = house.projection.site.plant
    handless = {
        name: msgspec.structs.replace(kind, abilities=("pallet",))
        for name, kind in plant.vehicle_types.items()
    }
    monkeypatch.setattr(plant, "vehicle_types", handless)
    needs = plant.materials["shaft"].ability
    assert needs != "pallet"
    [error] = (await house.client.post(PATH, json=DRAFT)).json()["errors"]
    assert (error["field"], error["code"], error["values"]) == ("item", "ability_nobody", {"carried": needs})


async def test_what_is_not_there_yet_is_taken_and_told_with_what_is_free_and_who_has_as_much(
    house: House,
) -> None:
    plant = house.projection.site.plant
    others = [each for each in plant.storages_of("shaft") if each != "S3"]

    def level(station: str, **fields: int) -> StationHeartbeat:
        stock = StockLevel("shaft", capacity=400, **fields)
        return station_heartbeat(station, 9, stocks=(stock,))

    await house.say([level("S3", level=50, promised=38, on_order=40)])
    await house.say([level(each, level=100) for each in others])
    lacks = {"free": 12, "on_order": 40, "elsewhere": others[:3]}
    answer = await called(house)
    assert {**answer["shortage"], "elsewhere": sorted(answer["shortage"]["elsewhere"])} == lacks
    first, second = events(
        "M8",
        progress(answer["id"], TransportState.WAITING, wait="short"),
        progress(answer["id"], TransportState.WAITING, wait="no_bid"),
    )
    await house.say([first])
    assert (await house.get(f"{PATH}/{answer['id']}"))["shortage"]["free"] == 12
    assert (await house.get(PATH))["items"][0]["shortage"]["free"] == 12
    await house.say(
        [station_heartbeat("S3", 10, stocks=(StockLevel("shaft", level=90, capacity=400, promised=38),))]
    )
    assert (await house.get(f"{PATH}/{answer['id']}"))["shortage"] is None
    await house.say(
        [station_heartbeat("S3", 11, stocks=(StockLevel("shaft", level=0, capacity=400),)), second]
    )
    assert (await house.get(f"{PATH}/{answer['id']}"))["shortage"] is None


PUMP = {"from": "M8", "to": "S3", "thing": " pump housing for Meier ", "ability": "tote"}


async def test_a_thing_without_master_data_is_asked_for_by_what_people_call_it(house: House) -> None:
    response = await house.client.post(PATH, json=PUMP)
    assert response.status_code == 201, response.text
    answer = response.json()
    assert (answer["item"], answer["thing"], answer["quantity"]) == (THING, "pump housing for Meier", 1)
    story = await house.get(f"{PATH}/{answer['id']}/timeline")
    assert [each["thing"] for each in story["moments"]] == ["pump housing for Meier"]
    [asked] = house.bus.sent_to("S3", TransportOrdered)
    assert (asked.source, asked.item, asked.quantity, asked.ability) == ("M8", THING, 1, "tote")
    assert await house.get(f"{PATH}/{answer['id']}") == answer
    assert [each["id"] for each in (await house.get(PATH, q="meier"))["items"]] == [answer["id"]]
    told = progress(answer["id"], TransportState.DELIVERED, item=THING, quantity=1)
    await house.say(events("S3", told))
    assert (await house.get(f"{PATH}/{answer['id']}"))["status"] == "delivered"
    material = await called(house)
    assert (material["thing"], material["item"]) == (None, "shaft")


@pytest.mark.parametrize(
    ("fields", "field", "code"),
    [
        ({"from": None}, "from", "thing_place"),
        ({"to": None}, "to", "thing_place"),
        ({"to": "nowhere"}, "to", "place_unknown"),
        ({"to": "M8"}, "to", "same_place"),
        ({"item": "shaft"}, "item", "thing_alone"),
        ({"quantity": 2}, "quantity", "thing_is_one"),
        ({"ability": None}, "ability", "thing_ability"),
        ({"ability": "crane"}, "ability", "thing_ability"),
        ({"thing": "  "}, "thing", "missing"),
        ({"thing": "x" * 101}, "thing", "too_long"),
        ({"thing": "a\nb"}, "thing", "pattern"),
        ({"thing": None}, "item", "missing"),
        ({"thing": None, "item": "shaft"}, "quantity", "missing"),
    ],
)
async def test_a_thing_that_cannot_be_brought_is_refused_with_the_field(
    house: House, fields: dict[str, Any], field: str, code: str
) -> None:
    answer = await house.client.post(PATH, json=PUMP | fields)
    assert answer.status_code == 422
    assert [(error["field"], error["code"]) for error in answer.json()["errors"]] == [(field, code)]


async def test_a_key_for_some_materials_calls_for_no_thing(house: House) -> None:
    _, header = await house.key(Scope.TRANSPORTS_CALL, places="M8", items="shaft")
    answer = await house.visitor(**header).post(PATH, json=PUMP)
    assert (answer.status_code, [error["code"] for error in answer.json()["errors"]]) == (403, ["only_items"])
    _, header = await house.key(Scope.TRANSPORTS_CALL, places="M8")
    assert (await house.visitor(**header).post(PATH, json=PUMP)).status_code == 201
