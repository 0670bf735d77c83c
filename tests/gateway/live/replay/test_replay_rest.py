"""The past over REST: its picture, the frames after it, what there is to see, what agents knew and did; and who may see how much of it."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from typing import Any

import pytest
from answers import problem
from areas_kit import ATV, everything
from failover_kit import accepted, opened
from gateway_kit import House, gateway
from heartbeats import atv_heartbeat, events
from wall_clock import NOW_S, Wall

from dray.gateway.access.principal import Role
from dray.gateway.live.frames import PORTION
from dray.gateway.live.replay import recorder
from dray.messages import Reason
from dray.messages import Role as Part
from dray.messages.fact import CarrierChanged, ContractEnded, ContractTaken

pytestmark = pytest.mark.anyio


def at(wall_s: float) -> str:
    return datetime.fromtimestamp(wall_s, UTC).isoformat()


async def beat(house: House, seq: int, **fields: Any) -> None:
    """A second passes, and a vehicle has said how it is."""
    house.wall.now_s += 1.0
    house.bus.say(atv_heartbeat(seq=seq, at_s=house.wall.now_s - NOW_S, **fields))
    house.hub.tick()


async def test_the_picture_of_a_moment_is_what_was_told_up_to_it(house: House) -> None:
    for seq in range(1, 11):
        await beat(house, seq, speed_mps=float(seq))
    picture = await house.get("/api/replay", at=at(NOW_S + 4.5))
    assert [each["speed_mps"] for each in picture["atvs"]] == [4.0]
    assert picture["at_s"] == NOW_S + 4
    assert (await house.get("/api/replay"))["atvs"][0]["speed_mps"] == 10.0


async def test_a_film_goes_on_from_its_picture_frame_by_frame_or_in_longer_steps(house: House) -> None:
    for seq in range(1, 21):
        await beat(house, seq, speed_mps=float(seq))
    span = {"since": at(NOW_S + 3), "until": at(NOW_S + 12)}
    film = await house.get("/api/replay/film", **span)
    assert film["snapshot"]["atvs"][0]["speed_mps"] == 3.0
    assert [frame["number"] for frame in film["frames"]] == list(range(1, 10))
    assert [frame["atvs"][0]["speed_mps"] for frame in film["frames"]] == [float(n) for n in range(4, 13)]
    assert film["until_at_s"] == NOW_S + 12
    quick = await house.get("/api/replay/film", **span, every_s=3)
    assert len(quick["frames"]) < 6
    assert quick["frames"][-1]["atvs"][0]["speed_mps"] == 12.0


async def test_what_was_written_and_what_is_not_yet_are_one(url: str) -> None:
    async with gateway(url) as house:
        for seq in range(1, 6):
            await beat(house, seq, speed_mps=float(seq))
        await house.recorder.write()
        for seq in range(6, 11):
            await beat(house, seq, speed_mps=float(seq))
        for moment, speed in ((2, 2.0), (5, 5.0), (7, 7.0), (10, 10.0)):
            picture = await house.get("/api/replay", at=at(NOW_S + moment))
            assert picture["atvs"][0]["speed_mps"] == speed
        overview = await house.get("/api/replay/overview")
        assert NOW_S <= overview["kept_from_at_s"] <= NOW_S + 1
        assert len(overview["stretches"]) == 1
    # A gateway that is started again knows what the one before has kept.
    later = Wall()
    later.now_s += 3600
    async with gateway(url, incarnation=2, wall=later) as house:
        picture = await house.get("/api/replay", at=at(NOW_S + 7))
        assert picture["atvs"][0]["speed_mps"] == 7.0


async def test_of_a_moment_before_all_that_is_kept_there_is_no_picture(house: House) -> None:
    await beat(house, 1)
    answer = await house.client.get("/api/replay", params={"at": at(NOW_S - 100)})
    problem(answer, 404, "not-kept")
    wrong = {"since": at(NOW_S), "until": at(NOW_S - 1)}
    problem(await house.client.get("/api/replay/film", params=wrong), 422, "unusable-fields")


@pytest.mark.parametrize("moment", ["2100-01-01T00:00:00Z", "9999-12-31T23:59:59Z"])
async def test_of_a_moment_that_has_not_come_there_is_the_last_picture_with_its_own_time(
    house: House, moment: str
) -> None:
    for seq in (1, 2, 3):
        await beat(house, seq, speed_mps=float(seq))
    picture = await house.get("/api/replay", at=moment)
    assert (picture["at_s"], picture["atvs"][0]["speed_mps"]) == (NOW_S + 3, 3.0)
    film = await house.get("/api/replay/film", since=moment, until=moment)
    assert film["frames"] == []


@pytest.mark.parametrize("moment", ["0001-01-01T00:00:00Z", "1969-12-31T23:59:59Z"])
async def test_of_a_moment_before_all_history_there_is_no_picture(house: House, moment: str) -> None:
    await beat(house, 1)
    problem(await house.client.get("/api/replay", params={"at": moment}), 404, "not-kept")


async def test_fifty_replays_at_once_get_each_its_own_moment(url: str) -> None:
    async with gateway(url) as house:
        for seq in range(1, 51):
            await beat(house, seq, speed_mps=float(seq))
            if seq % 10 == 0:
                await house.recorder.write()
        asked = [house.get("/api/replay", at=at(NOW_S + moment)) for moment in range(1, 51)]
        pictures = await asyncio.gather(*asked)
        assert [each["atvs"][0]["speed_mps"] for each in pictures] == [float(n) for n in range(1, 51)]


async def test_what_is_kept_for_fewer_days_than_before_goes_little_by_little(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "PIECES_FORGOTTEN", 2)
    for seq in range(1, 7):
        await beat(house, seq)
        await house.recorder.write()
    async with house.store.read() as work:
        before = len(await work.recordings.outlines(0.0, house.wall.now_s))
    house.recorder._kept_s = 0.5
    left: list[int] = []
    for seq in range(7, 12):
        await beat(house, seq)
        await house.recorder.write()
        async with house.store.read() as work:
            left.append(len(await work.recordings.outlines(0.0, house.wall.now_s)))
    # Each writing adds one and forgets two at most.
    assert left[:3] == [before - 1, before - 2, before - 3]
    assert min(left) >= 1


async def test_a_gateway_that_keeps_nothing_has_the_picture_of_now_alone(url: str) -> None:
    async with gateway(url, replay_days=0) as house:
        await beat(house, 1)
        placed = {(await house.place(reference=f"{number}"))["id"] for number in range(PORTION + 1)}
        picture = await house.get("/api/replay")
        assert picture["atvs"]
        assert {order["id"] for order in picture["orders"]} == placed
        assert (await house.get("/api/replay/film"))["snapshot"]["orders"] == picture["orders"]
        problem(await house.client.get("/api/replay", params={"at": at(NOW_S + 1)}), 404, "not-kept")
        assert (await house.get("/api/replay/overview"))["kept_from_at_s"] is None


async def test_an_operator_sees_of_the_past_what_is_in_the_areas(house: House) -> None:
    await house.say(everything())
    house.wall.now_s += 1
    house.hub.tick()
    operator = await house.log_in("anna", Role.OPERATOR, "AREA1")
    answer = await operator.get("/api/replay", params={"at": at(NOW_S + 2)})
    assert {each["id"] for each in answer.json()["atvs"]} == {ATV["AREA1"]}
    assert (await operator.get("/api/spells")).status_code == 403


async def test_what_an_agent_knew_stands_beside_what_had_happened(house: House) -> None:
    told = [
        *events("M8", opened(1), accepted("ATV3", 1), accepted("ATV1", 1, Part.SECONDARY), at_s=10.0),
        *events("ATV3", ContractTaken(task="T1", epoch=1, role=Part.PRIMARY, coordinator="M8"), at_s=11.0),
        *events(
            "M8",
            CarrierChanged(task="T1", epoch=2, replaced="ATV3", carrier="ATV1", reason=Reason.SILENT),
            at_s=20.0,
            first=4,
        ),
        *events(
            "ATV3",
            ContractEnded(task="T1", epoch=1, role=Part.PRIMARY, reason=Reason.SUPERSEDED),
            at_s=26.0,
            first=2,
        ),
    ]
    house.wall.now_s += 30
    await house.say([atv_heartbeat(atv="ATV3", at_s=11.0), *told])
    house.hub.tick()
    house.wall.now_s += 1
    # Of a moment that was recorded, and of the present.
    for moment in ({"at": at(NOW_S + 30.5)}, {}):
        answer = await house.client.get("/api/agents/ATV3/knowledge", params=moment)
        (item,) = [each for each in answer.json()["items"] if each["about"] == "task"]
        assert (item["knew"]["kind"], item["happened"]["kind"], item["differs"]) == (
            "ContractEnded",
            "CarrierChanged",
            False,
        )
    problem(await house.client.get("/api/agents/ATV99/knowledge"), 404, "unknown-agent")
    problem(
        await house.client.get("/api/agents/ATV99/knowledge", params={"at": at(NOW_S + 30.5)}),
        404,
        "unknown-agent",
    )


async def test_spells_tell_what_a_vehicle_did_and_that_it_fell_silent(house: House) -> None:
    await beat(house, 1)
    await beat(house, 2)
    house.wall.now_s += 1000
    house.hub.tick()
    items = (await house.get("/api/spells", agent="ATV1"))["items"]
    assert [each["doing"] for each in items] == ["idle", "silent"]
    assert items[0]["until_at_s"] == items[1]["from_at_s"] == NOW_S + 2
