"""Traffic: how often vehicles pass each lane, and how long they wait there."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest
from answers import problem
from fake_bus import PLANT
from gateway_kit import House, gateway
from heartbeats import atv_heartbeat
from wall_clock import NOW_S, Wall

from dray.gateway.factory.figure_sampler import KEPT_S, Sampler
from dray.gateway.live.projection.figures.time_use import SILENCE_S
from dray.gateway.live.projection.figures.traffic import WINDOW_S, Traffic, lanes_added
from dray.messages import AtvHeartbeat
from dray.plant.model import Lane
from dray.store.factory.lane_traffic import HOUR_S, LaneTraffic

LANES = (Lane("a", "b", both_ways=True), Lane("b", "c"), Lane("c", "d"))


@pytest.fixture
def traffic() -> Traffic:
    return Traffic(LANES)


def drive(traffic: Traffic, *heartbeats: AtvHeartbeat) -> None:
    for before, now in zip((None, *heartbeats), heartbeats, strict=False):
        traffic.follow(before, now)


def passes(traffic: Traffic, now_s: float = 10.0) -> dict[str, int]:
    return {f"{lane.start}{lane.end}": lane.passes for lane in traffic.lanes(now_s)}


def test_a_vehicle_that_stands_or_is_new_passes_nothing(traffic: Traffic) -> None:
    drive(traffic, atv_heartbeat(seq=1, node="a"), atv_heartbeat(seq=2, node="a"))
    assert passes(traffic) == {}


def test_every_lane_between_two_heartbeats_counts(traffic: Traffic) -> None:
    drive(traffic, atv_heartbeat(seq=1, node="a", way=("b", "c", "d")), atv_heartbeat(seq=2, node="c"))
    assert passes(traffic) == {"ab": 1, "bc": 1}


def test_who_leaves_its_way_still_passes_the_lane_that_it_takes(traffic: Traffic) -> None:
    drive(traffic, atv_heartbeat(seq=1, node="b", way=("c", "d")), atv_heartbeat(seq=2, node="a"))
    assert passes(traffic) == {"ba": 1}


def test_a_jump_that_no_lane_makes_counts_nothing(traffic: Traffic) -> None:
    drive(traffic, atv_heartbeat(seq=1, node="a"), atv_heartbeat(seq=2, node="d"))
    assert passes(traffic) == {}


def test_a_new_life_has_not_driven_from_where_the_old_one_ended(traffic: Traffic) -> None:
    drive(traffic, atv_heartbeat(seq=1, node="a"), atv_heartbeat(seq=1, incarnation=2, node="b"))
    assert passes(traffic) == {}


def test_what_is_older_than_the_window_is_forgotten(traffic: Traffic) -> None:
    drive(traffic, atv_heartbeat(seq=1, node="a"), atv_heartbeat(seq=2, node="b"))
    assert passes(traffic, 2.0 + WINDOW_S / 2) == {"ab": 1}
    assert passes(traffic, 2.0 + WINDOW_S) == {}


# --- waiting -----------------------------------------------------------------------------------------


def standing(seq: int, *, at_s: float | None = None, **fields: Any) -> AtvHeartbeat:
    usual: dict[str, Any] = {"node": "a", "way": ("b", "c"), "at_s": float(seq) if at_s is None else at_s}
    return atv_heartbeat(seq=seq, **usual | fields)


def waits(traffic: Traffic, now_s: float = 10.0) -> dict[str, tuple[int, float]]:
    return {f"{lane.start}{lane.end}": (lane.waits, lane.waited_s) for lane in traffic.lanes(now_s)}


def test_who_stands_with_a_way_before_it_waits_once_and_as_long_as_it_stands(traffic: Traffic) -> None:
    drive(
        traffic, *(standing(seq) for seq in (1, 2, 3)), standing(4, speed_mps=1.0), standing(5), standing(7)
    )
    assert waits(traffic) == {"ab": (2, 4.0)}
    assert passes(traffic) == {"ab": 0}


@pytest.mark.parametrize(
    "second",
    [
        standing(2, way=()),
        standing(2, speed_mps=0.1),
        standing(2, way=("c",)),
        standing(2, incarnation=2),
        standing(2, at_s=1.0),
        standing(2, at_s=1.0 + SILENCE_S + 1.0),
        standing(2, node="x", way=("y",)),
    ],
    ids=["arrived", "drives", "turned", "new life", "no later", "unheard", "no lane"],
)
def test_what_is_no_wait_is_not_counted(traffic: Traffic, second: AtvHeartbeat) -> None:
    drive(traffic, standing(1), second)
    assert waits(traffic) == {}


def test_what_has_come_between_two_totals_is_told_of_the_lanes_on_which_it_has(traffic: Traffic) -> None:
    drive(traffic, standing(1), standing(2), atv_heartbeat(seq=3, node="b"))
    before = traffic.totals()
    assert list(lanes_added({}, before)) == [LaneTraffic("a", "b", 1, 1, 1.0)]
    drive(traffic, atv_heartbeat(seq=4, node="b"), atv_heartbeat(seq=5, node="c"))
    assert list(lanes_added(before, traffic.totals())) == [LaneTraffic("b", "c", 1)]
    assert list(lanes_added(traffic.totals(), traffic.totals())) == []


# --- told --------------------------------------------------------------------------------------------

LANE = PLANT.lanes[0]
ENDS = {"start": LANE.start, "end": LANE.end}


def pass_once(house: House, seq: int = 1) -> None:
    house.bus.say(
        atv_heartbeat(seq=seq, node=LANE.start, at_s=100.0),
        atv_heartbeat(seq=seq + 1, node=LANE.end, at_s=100.0),
    )


@pytest.mark.anyio
async def test_the_traffic_is_told_over_rest(house: House) -> None:
    pass_once(house)
    assert await house.get("/api/traffic") == {
        "window_s": WINDOW_S,
        "items": [ENDS | {"passes": 1, "waits": 0, "waited_s": 0.0}],
        "since_at_s": None,
        "until_at_s": None,
    }


def moment(at_s: float) -> str:
    return datetime.fromtimestamp(at_s, UTC).isoformat()


@pytest.mark.anyio
async def test_a_period_is_told_by_whole_hours_also_after_a_restart(url: str) -> None:
    wall = Wall()
    hour_s = (NOW_S // HOUR_S + 1) * HOUR_S
    async with gateway(url, wall=wall) as house:
        sampler = Sampler(house.projection, house.store, house.wall)
        for hours in (0, 1):
            pass_once(house, seq=1 + 2 * hours)
            wall.now_s = hour_s + hours * HOUR_S + 60.0 + 60.0 * hours
            await sampler.sample()
    async with gateway(url, wall=wall, incarnation=2) as house:
        since = {"since": moment(hour_s)}
        both = await house.get("/api/traffic", **since)
        assert (both["since_at_s"], both["until_at_s"]) == (hour_s, hour_s + 2 * HOUR_S)
        assert ENDS | {"passes": 2, "waits": 0, "waited_s": 0.0} in both["items"]
        first = await house.get("/api/traffic", **since, until=moment(hour_s + 1.0))
        assert [lane["passes"] for lane in first["items"]] == [1]


@pytest.mark.anyio
@pytest.mark.parametrize(
    ("params", "field"),
    [
        ({"until": moment(NOW_S)}, "since"),
        ({"since": moment(NOW_S), "until": moment(NOW_S - 2 * HOUR_S)}, "until"),
        ({"since": moment(NOW_S - KEPT_S - 3 * HOUR_S)}, "since"),
    ],
)
async def test_a_period_that_cannot_be_is_refused(house: House, params: dict[str, str], field: str) -> None:
    answer = await house.client.get("/api/traffic", params=params)
    told = problem(answer, 422, "unusable-fields")
    assert [error["field"] for error in told["errors"]] == [field]


@pytest.mark.anyio
async def test_hours_add_up_and_the_old_ones_are_forgotten(house: House) -> None:
    ab = LaneTraffic("a", "b", 2, 1, 3.5)
    async with house.store.write() as work:
        for at_s in (7200.0, 7300.0, 10_900.0):
            await work.lane_hours.add(at_s, [ab])
        await work.lane_hours.add(7400.0, [LaneTraffic("b", "c", 1)])
        await work.lane_hours.add(7400.0, [])
    async with house.store.write() as work:
        assert await work.lane_hours.between(7200.0, 10_800.0) == [ab + ab, LaneTraffic("b", "c", 1)]
        await work.lane_hours.forget_before(10_800.0)
        assert await work.lane_hours.between(0.0, 20_000.0) == [ab]
