"""Carrying a vehicle away and putting it back: who may say so, when, what is told on the bus, and what panels see."""

from __future__ import annotations

import asyncio
from typing import Any

import msgspec
import pytest
from fake_bus import KEYS, FakeBus
from gateway_kit import AUTHORITY, House
from heartbeats import atv_heartbeat
from msgspec import UNSET
from wall_clock import NOW_S

from dray.adapters.security.signing import TrustedKeys
from dray.gateway.factory.carrying import Carrying
from dray.gateway.http.provided import provided
from dray.gateway.live.projection.agents.removals import REFUSED_KEPT
from dray.gateway.live.visibility import visibility_of
from dray.messages import Event, Message, Removal, RemovalRefusal, Removals, removed_words, reported_words
from dray.messages.base import CLOCK_WRONG_S, COUNT_MAX
from dray.messages.fact import PlaceKept, PlacesFreed, RemovalRefused
from dray.messages.heartbeat import FloorBrief
from dray.store.factory.removals import FROM_CONSOLE, RemovalRow

pytestmark = pytest.mark.anyio

OFF = {"off_the_floor": True}


@pytest.fixture(autouse=True)
def said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gateway's own first look may be late on a slow machine: here only the tests look, and count what is told."""

    async def never(_carrying: Carrying) -> None:
        await asyncio.Event().wait()

    monkeypatch.setattr(Carrying, "run", never)


def listener(bus: FakeBus) -> list[Removal]:
    heard: list[Removal] = []

    def receive(_sender: str, message: Message) -> None:
        if isinstance(message, Removals):
            heard.extend(message.removals)

    bus.join("M1", receive).subscribe(KEYS.removals)
    return heard


def heard(house: House, *, seq: int = 7, ago_s: float = 60.0, atv: str = "ATV1", **more: Any) -> None:
    at_s = house.projection.plant_s(NOW_S - ago_s)
    floor = FloorBrief(**more)
    beat = msgspec.structs.replace(atv_heartbeat(atv), seq=seq, incarnation=1, at_s=at_s, floor=floor)
    house.projection.fold(beat)


async def say(house: House, what: str, status: int = 200, **body: Any) -> dict[str, Any]:
    answer = await house.client.post(f"/api/atvs/ATV1/{what}", json=body)
    assert answer.status_code == status, answer.text
    told: dict[str, Any] = answer.json()
    return told


async def test_it_is_told_to_everybody_with_a_grant_and_shown(house: House) -> None:
    told = listener(house.bus)
    heard(house)
    view = await say(house, "carried-away", **OFF)
    assert (view["by"], view["node"]) == ("Administrator", "")
    assert view["believed_at_s"] == pytest.approx(NOW_S - 60.0 + 65.0)
    (removal,) = told
    assert (removal.atv, removal.life, removal.seq, removal.grant.everywhere) == ("ATV1", 1, 7, True)
    assert TrustedKeys(AUTHORITY.public)(removed_words(removal), removal.grant.signature)


async def test_it_is_told_when_the_person_said_it_however_often_it_is_repeated(house: House) -> None:
    """The gateway may know an older heartbeat than the machines do: it was cut off, or has begun since."""
    told = listener(house.bus)
    heard(house)
    said_s = house.wall.now_s
    await say(house, "carried-away", **OFF)
    house.wall.now_s += 30.0
    await provided(house.app, Carrying).look()
    times = [each.reported for each in told]
    assert [(time.at_s, time.signed_s) for time in times if time is not UNSET] == [
        (house.projection.plant_s(said_s), pytest.approx(house.projection.plant_s(wall_s)))
        for wall_s in (said_s, said_s + 30.0)
    ]
    for each, time in zip(told, times, strict=True):
        assert time is not UNSET
        assert TrustedKeys(AUTHORITY.public)(reported_words(each, time), time.signature)


async def test_a_word_from_the_future_counts_from_now_on(house: House) -> None:
    """It was said at a computer whose clock is ahead: what is heard of the vehicle until that time comes after the word."""
    told = listener(house.bus)
    row = RemovalRow("GHOST", 0, 0, 0, "", "null", "maria", f"{FROM_CONSOLE}maria", NOW_S + 600.0)
    async with house.store.write() as work:
        await work.removals.put(row)
    await provided(house.app, Carrying).look()
    house.wall.now_s += 700.0
    await provided(house.app, Carrying).look()
    times = [each.reported.at_s for each in told if each.reported is not UNSET]
    assert times == [pytest.approx(house.projection.plant_s(NOW_S))] * 2
    assert len({each.number for each in told}) == 1


async def test_who_was_carried_away_is_no_alarm(house: House) -> None:
    def lost() -> list[str]:
        house.projection.look(house.wall.now_s)
        return [alert.agent for alert in house.projection.alerts.views() if alert.kind == "atv_lost"]

    vehicles = [f"ATV{number}" for number in range(1, 7)]
    for atv in vehicles:
        heard(house, atv=atv, ago_s=0.0)
    house.wall.now_s += 60.0
    for atv in vehicles[2:]:
        heard(house, atv=atv, seq=8, ago_s=-60.0)
    assert lost() == ["ATV1", "ATV2"]
    await say(house, "carried-away", **OFF)
    assert lost() == ["ATV2"]


async def test_a_vehicle_that_is_heard_is_on_the_floor(house: House) -> None:
    told = listener(house.bus)
    heard(house, ago_s=1.0)
    assert (await say(house, "carried-away", 409, **OFF))["type"].endswith("is-heard")
    assert told == []


async def test_one_that_was_never_heard_is_off_the_floor_too(house: House) -> None:
    told = listener(house.bus)
    view = await say(house, "carried-away", **OFF)
    assert (view["by"], view["freed"]) == ("Administrator", [])
    (removal,) = told
    assert (removal.atv, removal.life, removal.seq) == ("ATV1", 0, 0)


async def test_it_must_be_said_in_so_many_words(house: House) -> None:
    heard(house)
    await say(house, "carried-away", 422, off_the_floor=False)
    await say(house, "carried-away", 422)


async def test_what_is_free_and_kept_is_shown_as_replicas_tell_it(house: House) -> None:
    heard(house)
    number = (await say(house, "carried-away", **OFF))["number"]
    house.bus.say(fact(PlacesFreed(atv="ATV1", number=number, by="x", places=("c3", "b3"))))
    assert (await house.get("/api/atvs/ATV1"))["removal"]["freed"] == ["b3", "c3"]
    back = await say(house, "put-back", place="p1")
    assert (back["node"], back["kept"]) == ("p1", False)
    assert back["number"] > number
    house.projection.fold(fact(PlaceKept(atv="ATV1", number=back["number"], place="p1"), 2))
    assert (await house.get("/api/atvs/ATV1"))["removal"]["kept"]


async def refused(house: House) -> list[tuple[str, str]]:
    removal = (await house.get("/api/atvs/ATV1"))["removal"]
    assert all(each["text"] for each in removal["refused"])
    return [(each["agent"], each["reason"]) for each in removal["refused"]]


async def test_who_refuses_the_report_is_shown_with_the_reason_until_it_frees_the_places(
    house: House,
) -> None:
    heard(house)
    number = (await say(house, "carried-away", **OFF))["number"]
    assert await refused(house) == []
    for count, (agent, reason) in enumerate(
        (("M5", "not_there"), ("M4", "expired"), ("M4", "heard_since")), 1
    ):
        why = RemovalRefused("ATV1", number, RemovalRefusal(reason))
        house.bus.say(fact(why, count, agent))
    assert await refused(house) == [("M4", "heard_since"), ("M5", "not_there")]
    house.bus.say(fact(RemovalRefused("ATV1", number - 1, RemovalRefusal.EXPIRED), 4, "M6"))
    house.bus.say(fact(PlacesFreed(atv="ATV1", number=number, by="x", places=("c3",)), 5))
    assert await refused(house) == [("M5", "not_there")]
    await say(house, "put-back", place="p1")
    assert await refused(house) == []


async def test_a_refusal_that_comes_before_this_gateway_has_read_the_report_is_shown_too(
    house: House,
) -> None:
    """Another gateway has published it. Of what nobody has carried away no more is kept than a bound."""
    heard(house)
    row = RemovalRow("ATV1", 0, 1, 7, "", "null", "maria", "person:maria", NOW_S)
    async with house.store.write() as work:
        stored = await work.removals.put(row)
    house.projection.fold(fact(RemovalRefused("ATV1", stored.number, RemovalRefusal.EXPIRED)))
    await provided(house.app, Carrying).look()
    for count in range(2 * REFUSED_KEPT):
        house.projection.fold(fact(RemovalRefused(f"X{count}", 1, RemovalRefusal.EXPIRED), count + 2))
    assert await refused(house) == [("M4", "expired")]
    assert len(house.projection.removals._refused) == REFUSED_KEPT + 1


async def test_answers_from_before_the_gateways_start_are_read_again(house: House) -> None:
    """Machines tell them once."""
    heard(house)
    number = (await say(house, "carried-away", **OFF))["number"]
    answers = (
        RemovalRefused("ATV1", number, RemovalRefusal.HEARD_SINCE),
        PlacesFreed(atv="ATV1", number=number, by="x", places=("c3",)),
    )
    events = [fact(answers[0], 1, "M5"), fact(answers[1], 1, "M4")]
    assert await refused(house) == []
    async with house.store.write() as work:
        await work.events.add(events, lambda _plant_s: house.wall.now_s)
    await provided(house.app, Carrying).restore()
    assert await refused(house) == [("M5", "heard_since")]
    assert (await house.get("/api/atvs/ATV1"))["removal"]["freed"] == ["c3"]


async def test_each_refusal_is_logged_once(house: House, caplog: pytest.LogCaptureFixture) -> None:
    heard(house)
    number = (await say(house, "carried-away", **OFF))["number"]
    for reason in (RemovalRefusal.EXPIRED, RemovalRefusal.HEARD_SINCE):
        house.projection.fold(fact(RemovalRefused("ATV1", number, reason)))
        for _ in range(3):
            await provided(house.app, Carrying).look()
    said = [each.getMessage() for each in caplog.records if each.name == Carrying.__module__]
    assert [each.partition(":")[0] for each in said] == ["M4 does not believe that ATV1 was carried away"] * 2
    assert said[0] != said[1]


async def test_an_operator_reads_no_names_of_machines_elsewhere(house: House) -> None:
    heard(house)
    number = (await say(house, "carried-away", **OFF))["number"]
    plant = house.projection.site.plant
    area = next(iter(plant.areas))
    is_here = {machine: area in plant.areas_at(*plant.position_of(machine)) for machine in plant.machines}
    here, there = (
        next(machine for machine in is_here if is_here[machine] is which) for which in (True, False)
    )
    for agent in (here, there):
        house.projection.fold(fact(RemovalRefused("ATV1", number, RemovalRefusal.EXPIRED), 1, agent))
    view = house.projection.atvs.view("ATV1")
    assert view is not None
    x_m, y_m = plant.position_of(here)
    view = msgspec.structs.replace(view, x_m=x_m, y_m=y_m)
    shown = visibility_of(house.projection, frozenset({area})).atv(view)
    assert shown is not None
    assert shown.removal is not None
    assert {each.agent for each in shown.removal.refused} == {here, ""}


async def test_it_ends_when_the_vehicle_is_heard_again(house: House) -> None:
    told = listener(house.bus)
    heard(house)
    await say(house, "carried-away", **OFF)
    heard(house, seq=8, ago_s=0.0)
    await provided(house.app, Carrying).look()
    assert (await house.get("/api/atvs/ATV1"))["removal"] is None
    assert len(told) == 1


async def test_it_ends_when_the_vehicle_is_heard_again_whose_last_heartbeat_was_a_thiefs(
    house: House,
) -> None:
    """Its own numbers are lower; so are those of a vehicle whose journal is lost."""
    heard(house, seq=COUNT_MAX)
    await say(house, "carried-away", **OFF)
    house.wall.now_s += 60.0
    heard(house, seq=8, ago_s=-60.0)
    await provided(house.app, Carrying).look()
    assert (await house.get("/api/atvs/ATV1"))["removal"] is None


async def test_a_clock_that_is_ahead_makes_no_vehicle_heard_for_longer(house: House) -> None:
    """A thief of its certificate states a time that a gateway still takes for a clock's."""
    heard(house, ago_s=-0.9 * CLOCK_WRONG_S)
    await say(house, "carried-away", 409, **OFF)
    house.wall.now_s += 60.0
    await say(house, "carried-away", **OFF)
    await provided(house.app, Carrying).look()
    assert (await house.get("/api/atvs/ATV1"))["removal"] is not None


async def test_it_is_said_again_with_a_new_grant_while_the_vehicle_is_silent(house: House) -> None:
    told = listener(house.bus)
    heard(house)
    await say(house, "carried-away", **OFF)
    await provided(house.app, Carrying).look()
    assert [each.number for each in told] == [told[0].number] * 2


async def test_only_what_was_carried_away_is_put_back_and_not_where_another_one_is(house: House) -> None:
    heard(house)
    assert (await say(house, "put-back", 409, place="p1"))["type"].endswith("not-carried-away")
    await say(house, "carried-away", **OFF)
    heard(house, atv="ATV2", ago_s=0.0, holds=("p1",))
    assert (await say(house, "put-back", 409, place="p1"))["type"].endswith("place-held")
    await say(house, "put-back", 422, place="nowhere")
    await say(house, "put-back", place="p2")


async def test_a_vehicle_that_nobody_knows_is_not_found(house: House) -> None:
    answer = await house.client.post("/api/atvs/NOBODY/carried-away", json=OFF)
    assert answer.status_code == 404


def fact(told: PlacesFreed | PlaceKept | RemovalRefused, number: int = 1, agent: str = "M4") -> Event:
    return Event(agent=agent, incarnation=1, number=number, at_s=0.0, fact=told)


async def test_whoever_a_table_names_can_be_carried_away_and_shut_out_though_nobody_has_heard_it(
    house: House,
) -> None:
    for what, body in (("atvs/GHOST/carried-away", OFF), ("agents/GHOST/shut-out", {"reason": "no body"})):
        unknown = await house.client.post(f"/api/{what}", json=body)
        assert unknown.status_code == 404
    told = listener(house.bus)
    heard(house, ago_s=0.0, waits=True, waits_for="GHOST")
    for what, body in (("atvs/GHOST/carried-away", OFF), ("agents/GHOST/shut-out", {"reason": "no body"})):
        answer = await house.client.post(f"/api/{what}", json=body)
        assert answer.status_code == 200, answer.text
    (removal,) = told
    assert (removal.atv, removal.life, removal.seq) == ("GHOST", 0, 0)


async def test_a_word_from_the_console_is_told_with_the_heartbeat_that_was_heard_last(house: House) -> None:
    told = listener(house.bus)
    for atv, ago_s in (("ATV1", 60.0), ("ATV2", 0.0)):
        heard(house, atv=atv, ago_s=ago_s)
    rows = [
        RemovalRow(atv, 0, 0, 0, "", "null", "maria", f"{FROM_CONSOLE}maria", NOW_S)
        for atv in ("ATV1", "ATV2", "GHOST")
    ]
    async with house.store.write() as work:
        for row in rows:
            await work.removals.put(row)
    await provided(house.app, Carrying).look()
    assert [(each.atv, each.life, each.seq) for each in told] == [("ATV1", 1, 7), ("GHOST", 0, 0)]
