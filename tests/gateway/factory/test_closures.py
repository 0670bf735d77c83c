"""Closing a lane, a place or an area: a manager decides it, vehicles are told at once, and it ends when it should."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from answers import problem
from fake_bus import KEYS, FakeBus
from gateway_kit import AUTHORITY, House, gateway
from heartbeats import atv_heartbeat
from wall_clock import NOW_S

from dray.adapters.security.signing import TrustedKeys
from dray.gateway.access.principal import Role, Scope
from dray.gateway.factory.closings import Closings
from dray.gateway.http.provided import provided
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream_scopes import AreaScope
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import ClosureView, LaneView
from dray.gateway.live.visibility import AreaVisibility
from dray.gateway.routes.factory.floor.closures import ClosureRequest
from dray.gateway.routes.factory.floor.obstacles import ClearedRequest
from dray.messages import ClosureKind, Closures, Message, closed_words
from dray.messages.floor.closure import MAX_CLOSURES
from dray.plant import load_plant
from dray.protocol.closures.closure_rules import restrictions_of

pytestmark = pytest.mark.anyio

EVERY_S = Closings.EVERY_S
"""Outside tests."""


PLANT = load_plant("single-track")

API = Path(__file__).parents[3] / "docs/api.md"

LANE = {"lane": {"start": "c3", "end": "m5-lane"}}

WHY = {"reason": "oil on the floor"}

LATER = "2030-03-17T18:00:00Z"
"""Some minutes after the beginning."""

DECIDED = int(NOW_S * 1000)


def listener(bus: FakeBus, told: Callable[[], None] = lambda: None) -> list[Closures]:
    """What vehicles hear from now on; `told` is called with each."""
    heard: list[Closures] = []

    def receive(_sender: str, message: Message) -> None:
        if isinstance(message, Closures):
            heard.append(message)
            told()

    bus.join("ATV1", receive).subscribe(KEYS.closures)
    return heard


async def close(house: House, status: int = 201, **body: Any) -> dict[str, Any]:
    answer = await house.client.post("/api/closures", json=WHY | (body or LANE))
    assert answer.status_code == status, answer.text
    told: dict[str, Any] = answer.json()
    return told


def closings(house: House) -> Closings:
    return provided(house.app, Closings)


async def items(house: House) -> list[dict[str, Any]]:
    told: list[dict[str, Any]] = (await house.get("/api/closures"))["items"]
    return told


async def test_what_is_closed_is_told_to_everybody_and_shown_with_who_why_and_until_when(
    house: House,
) -> None:
    heard = listener(house.bus)
    told = await close(house, **LANE, until=LATER)
    assert (told["kind"], told["lane"], told["place"], told["area"]) == ("closed", LANE["lane"], "", "")
    assert (told["by"], told["reason"], told["at_s"]) == ("Administrator", WHY["reason"], NOW_S)
    assert told["until_at_s"] > NOW_S
    assert told["cut_off"] == []
    assert {(lane["start"], lane["end"]) for lane in told["lanes"]} == {("c3", "m5-lane"), ("m5-lane", "c3")}
    said = heard[0]
    [closure] = said.closures
    assert (said.number, closure.kind, closure.start, closure.end) == (
        DECIDED,
        ClosureKind.CLOSED,
        "c3",
        "m5-lane",
    )
    assert closure.by == "admin:admin"
    assert closure.until_s == pytest.approx(house.projection.plant_s(told["until_at_s"]))
    assert restrictions_of(PLANT, said.closures).lanes == {("c3", "m5-lane"), ("m5-lane", "c3")}
    assert await items(house) == [told]
    assert [view.id for view in house.projection.snapshot(1, NOW_S).closures] == [told["id"]]


async def test_vehicles_believe_the_list_by_the_gateways_signature(house: House) -> None:
    trusts = TrustedKeys(AUTHORITY.public)
    heard = listener(house.bus)
    await close(house)
    assert trusts(closed_words(heard[0].number, heard[0].closures), heard[0].signature)


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ({"place": "M5"}, {("m5-lane", "m5")}),
        ({"place": "m5"}, {("m5-lane", "m5")}),
        ({"kind": "one_way", "lane": {"start": "m5-lane", "end": "m5"}}, {("m5", "m5-lane")}),
        ({"kind": "slow", "place": "M5", "speed_mps": 0.3}, {("m5-lane", "m5"), ("m5", "m5-lane")}),
    ],
)
async def test_places_and_directions_are_told_as_lanes(
    house: House, body: dict[str, Any], named: set[tuple[str, str]]
) -> None:
    told = await close(house, **body)
    assert {(lane["start"], lane["end"]) for lane in told["lanes"]} == named
    assert told["cut_off"] == ([] if told["kind"] == "slow" else ["M5"])


async def test_an_area_is_closed_with_all_that_lies_in_it(house: House) -> None:
    area = next(iter(PLANT.areas))
    told = await close(house, area=area)
    inside = [place for place in PLANT.places if PLANT.is_in(*PLANT.position_of(place), (area,))]
    assert inside
    assert set(inside) <= set(told["cut_off"])


async def test_a_closure_is_ended_by_its_id_and_vehicles_hear_of_it(house: House) -> None:
    heard = listener(house.bus)
    told = await close(house)
    house.wall.now_s += 60.0
    answer = await house.client.delete(f"/api/closures/{told['id']}")
    assert answer.json() == told
    assert heard[-1].closures == ()
    assert heard[-1].number > heard[0].number
    assert await items(house) == []
    problem(await house.client.delete(f"/api/closures/{told['id']}"), 404, "unknown-closure")


async def test_the_same_again_is_one_closure_and_another_end_another_one(house: House) -> None:
    heard = listener(house.bus)
    first = await close(house)
    assert await close(house, 200, **LANE, reason="said again") == first
    assert {said.number for said in heard} == {DECIDED}
    assert (await close(house, **LANE, until=LATER))["id"] != first["id"]
    assert len(await items(house)) == 2


async def test_a_closure_ends_when_its_time_has_come_under_a_number_of_its_own(house: House) -> None:
    heard = listener(house.bus)
    told = await close(house, **LANE, until=LATER)
    house.wall.now_s = told["until_at_s"] - 0.5
    await closings(house).look()
    assert len(heard[-1].closures) == 1
    house.wall.now_s = told["until_at_s"]
    await closings(house).look()
    assert heard[-1].closures == ()
    assert heard[-1].number > heard[0].number
    assert await items(house) == []


async def test_the_list_is_said_again_and_again_and_nothing_where_nothing_was_ever_closed(
    house: House,
) -> None:
    heard = listener(house.bus)
    await closings(house).look()
    assert heard == []
    await close(house)
    await closings(house).look()
    assert heard[1:] == [heard[0]] * len(heard[1:])
    assert len(heard) >= 2
    assert EVERY_S <= 5.0


async def test_a_clock_that_was_set_back_makes_no_decision_older_than_the_one_before(house: House) -> None:
    heard = listener(house.bus)
    await close(house)
    house.wall.now_s -= 3600.0
    await close(house, place="M5")
    assert list(dict.fromkeys(said.number for said in heard)) == [DECIDED, DECIDED + 1]


async def test_it_outlives_a_restart_of_the_gateway(url: str) -> None:
    async with gateway(url) as house:
        told = await close(house)
    bus, said = FakeBus(), asyncio.Event()
    heard = listener(bus, said.set)
    async with gateway(url, bus=bus) as house:
        await said.wait()
        assert heard[0].number == DECIDED
        assert [each["id"] for each in await items(house)] == [told["id"]]


async def test_what_is_decided_at_another_gateway_is_seen_and_told(url: str) -> None:
    bus = FakeBus()
    async with (
        gateway(url, bus=bus, gateway_name="g1") as first,
        gateway(url, bus=bus, gateway_name="g2") as other,
    ):
        told = await close(first)
        heard = listener(bus)
        await closings(other).look()
        assert {said.number for said in heard} == {DECIDED}
        assert [each["id"] for each in await items(other)] == [told["id"]]


async def test_it_is_written_down_who_did_it_and_why(house: House) -> None:
    boss = await house.log_in("maria")
    told = (await boss.post("/api/closures", json=WHY | LANE)).json()
    assert told["by"] == "Maria"
    assert (await boss.delete(f"/api/closures/{told['id']}")).status_code == 200
    opened, closed = await house.audit(target=told["id"])
    assert (closed.action, closed.who, closed.result) == ("floor.close", "maria", "done")
    assert (opened.action, opened.who, opened.result) == ("floor.open", "maria", "done")
    assert WHY["reason"].encode() in bytes(closed.detail)
    assert b"m5-lane" in bytes(closed.detail)
    assert WHY["reason"].encode() in bytes(opened.detail)


async def test_vehicles_that_do_not_go_by_it_yet_are_named(house: House) -> None:
    house.bus.say(atv_heartbeat("ATV1"), atv_heartbeat("ATV2"))
    told = await close(house)
    assert told["not_known_by"] == ["ATV1", "ATV2"]
    house.projection.discard_changes()
    house.bus.say(atv_heartbeat("ATV1", seq=2, closures=DECIDED))
    [changed] = house.projection.closures.take_changed()
    assert changed.not_known_by == ("ATV2",)
    house.bus.say(
        atv_heartbeat("ATV2", seq=2, closures=DECIDED + 5), atv_heartbeat("ATV1", seq=3, closures=DECIDED)
    )
    assert (await items(house))[0]["not_known_by"] == []
    more = await close(house, place="M5")
    assert more["not_known_by"] == ["ATV1"]


# --- before it is closed -------------------------------------------------------------------------


async def test_a_preview_names_what_would_be_cut_off_and_closes_nothing(house: House) -> None:
    heard = listener(house.bus)
    house.bus.say(atv_heartbeat("ATV1", node="m5"))
    answer = await house.client.post("/api/closures/preview", json=WHY | {"place": "M5"})
    assert answer.json() == {"cut_off": ["M5"], "shut_in": []}, "who is inside may leave"
    shut = {"lane": {"start": "m5-lane", "end": "m5"}}
    answer = await house.client.post("/api/closures/preview", json=WHY | shut)
    assert answer.json() == {"cut_off": ["M5"], "shut_in": ["ATV1"]}
    assert heard == []
    assert await items(house) == []


async def test_a_preview_counts_what_is_closed_already(house: House) -> None:
    gates = [lane for lane in PLANT.lanes if lane.end == "m5-lane" and lane.start != "m5"]
    assert len(gates) == 2
    one, other = ({"lane": {"start": lane.start, "end": lane.end}} for lane in gates)
    before = await house.client.post("/api/closures/preview", json=WHY | other)
    assert before.json()["cut_off"] == []
    assert (await close(house, **one))["cut_off"] == []
    after = await house.client.post("/api/closures/preview", json=WHY | other)
    assert after.json()["cut_off"] == ["M5"]


# --- who and what is refused ---------------------------------------------------------------------


async def test_operators_and_keys_without_the_scope_close_nothing(house: House) -> None:
    told = await close(house)
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    _, header = await house.key(*(set(Scope) - {Scope.FLOOR_WRITE}))
    for somebody in (ana, house.visitor(**header)):
        assert (await somebody.post("/api/closures", json=WHY | {"place": "M5"})).status_code == 403
        assert (await somebody.delete(f"/api/closures/{told['id']}")).status_code == 403
    assert [each["id"] for each in await items(house)] == [told["id"]]


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({}, "lane"),
        ({"place": "M5", "area": "AREA1"}, "lane"),
        ({"lane": {"start": "c3", "end": "nowhere"}}, "lane"),
        ({"lane": {"start": "a1", "end": "f5"}}, "lane"),
        ({"place": "nowhere"}, "place"),
        ({"area": "nowhere"}, "area"),
        ({**LANE, "until": "2020-01-01T00:00:00Z"}, "until"),
        ({**LANE, "until": "2999-01-01T00:00:00Z"}, "until"),
        ({**LANE, "kind": "slow"}, "speed_mps"),
        ({**LANE, "speed_mps": 0.5}, "speed_mps"),
        ({"kind": "one_way", "place": "M5"}, "lane"),
        ({**LANE, "until": "2030-03-17T18:00:00"}, "until"),
        ({**LANE, "kind": "slow", "speed_mps": 0.0}, "speed_mps"),
        ({**LANE, "kind": "slow", "speed_mps": 1e9}, "speed_mps"),
        ({**LANE, "kind": "shut"}, "kind"),
        ({**LANE, "color": "red"}, "color"),
        ({**LANE, "reason": ""}, "reason"),
        ({**LANE, "reason": "two\nlines"}, "reason"),
        ({**LANE, "reason": "x" * 201}, "reason"),
        ({"place": "x" * 129}, "place"),
    ],
)
async def test_what_cannot_be_closed_is_refused_with_the_field(
    quiet_house: House, body: dict[str, Any], field: str
) -> None:
    heard = listener(quiet_house.bus)
    for path in ("/api/closures", "/api/closures/preview"):
        answer = await quiet_house.client.post(path, json=WHY | body)
        told = problem(answer, 422, answer.json()["type"].rpartition(":")[2])
        assert field in {error["field"].split(".")[0] for error in told["errors"]}, told
    assert heard == []


async def test_a_lane_that_runs_one_way_is_named_in_that_direction(url: str) -> None:
    plant = load_plant("two-halls")
    lane = next(lane for lane in plant.lanes if plant.roads.lane(lane.end, lane.start) is None)
    async with gateway(url, plant=plant.file) as house:
        wrong = {"lane": {"start": lane.end, "end": lane.start}}
        told = problem(await house.client.post("/api/closures", json=WHY | wrong), 422, "unusable-fields")
        assert f"from {lane.start} to {lane.end} only" in told["detail"]
        right = {"lane": {"start": lane.start, "end": lane.end}, "kind": "one_way"}
        told = problem(await house.client.post("/api/closures", json=WHY | right), 422, "unusable-fields")
        assert "one-way already" in told["detail"]


async def test_a_road_of_two_lanes_is_named_by_either_lane_and_in_either_direction(url: str) -> None:
    there, back = ("a1.to-b1", "b1.from-a1"), ("b1.to-a1", "a1.from-b1")
    async with gateway(url, plant=load_plant("default").file) as house:
        told = await close(house, lane={"start": back[0], "end": back[1]})
        assert {(lane["start"], lane["end"]) for lane in told["lanes"]} == {there, back}
        told = await close(house, lane={"start": there[1], "end": there[0]}, kind="one_way")
        assert [(lane["start"], lane["end"]) for lane in told["lanes"]] == [there]


async def test_too_much_is_not_closed(house: House) -> None:
    for lane in PLANT.lanes[:MAX_CLOSURES]:
        await close(house, lane={"start": lane.start, "end": lane.end})
    more = PLANT.lanes[MAX_CLOSURES]
    body = WHY | {"lane": {"start": more.start, "end": more.end}}
    told = problem(await house.client.post("/api/closures", json=body), 409, "too-much-closed")
    assert str(MAX_CLOSURES) in told["detail"]


async def test_an_unchanged_list_is_not_sent_twice(house: House) -> None:
    await close(house)
    first = await house.client.get("/api/closures")
    again = await house.client.get("/api/closures", headers={"If-None-Match": first.headers["etag"]})
    assert again.status_code == 304


async def test_an_operator_sees_the_lanes_in_the_own_area_only(house: House) -> None:
    left, right = list(PLANT.areas)[:2]
    await close(house, area=left)
    [whole] = house.projection.closures.views()
    there = AreaVisibility(house.projection, frozenset({left})).closure(whole)
    assert there is not None
    assert 0 < len(there.lanes) <= len(whole.lanes)
    elsewhere = AreaVisibility(house.projection, frozenset({right})).closure(whole)
    assert elsewhere is None or len(elsewhere.lanes) < len(whole.lanes)


def test_the_stream_of_an_area_has_its_closures_and_tells_when_they_have_ended() -> None:
    projection = Projection(PLANT.file, TimeScale(0.0, NOW_S))
    left, right = list(PLANT.areas)[:2]
    scopes = {
        area: AreaScope(projection, AreaVisibility(projection, frozenset({area}))) for area in (left, right)
    }
    machine = next(each for each in PLANT.machines if PLANT.is_in(*PLANT.position_of(each), (left,)))
    dock = PLANT.node_of(machine)
    [lane] = PLANT.roads.entering[dock]
    lanes = (LaneView(start=lane.start, end=lane.end),)
    view = ClosureView(
        id="c1", kind="closed", place=machine, reason="oil", by="Maria", at_s=NOW_S, lanes=lanes
    )
    projection.closures.put([(view, DECIDED)])
    told = projection.delta(1, NOW_S, None)
    assert scopes[left].delta(told).closures == (view,)
    assert scopes[right].delta(told).closures == ()
    assert scopes[left].snapshot(2, NOW_S).closures == (view,)
    projection.closures.put([])
    told = projection.delta(3, NOW_S, None)
    assert scopes[left].delta(told).gone == ("closure:c1",)
    assert scopes[right].delta(told).gone == ()


# --- examples ---------------------------------------------------------------------------------------


def examples_of_a_closure() -> list[dict[str, Any]]:
    """Bodies of closures in the OpenAPI document and in docs/api.md."""
    told = ClosureRequest.model_json_schema()["examples"]
    [written] = re.findall(
        r"^    POST /api/closures\n    (.*)$", API.read_text(encoding="utf-8"), re.MULTILINE
    )
    return [*told, json.loads(written)]


@pytest.mark.parametrize("body", examples_of_a_closure())
async def test_each_example_is_a_closure_of_the_plant_that_a_newcomer_starts(
    url: str, body: dict[str, Any]
) -> None:
    async with gateway(url, plant=load_plant("default").file) as house:
        answer = await house.client.post("/api/closures", json=body)
        assert answer.status_code == 201, answer.text


def test_the_example_of_an_obstacle_names_a_lane_of_that_plant() -> None:
    [lane] = ClearedRequest.model_json_schema()["examples"]
    assert load_plant("default").roads.lane(lane["start"], lane["end"]) is not None
    written = json.dumps({"start": lane["start"], "end": lane["end"]})
    assert f"/api/obstacles/cleared` with `{written}`" in API.read_text(encoding="utf-8")
