"""Traffic: how often vehicles pass each lane."""

from __future__ import annotations

import pytest
from fake_bus import PLANT
from gateway_kit import House
from heartbeats import atv_heartbeat

from dray.gateway.live.projection.figures.traffic import WINDOW_S, Traffic
from dray.messages import AtvHeartbeat
from dray.plant.model import Lane

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


@pytest.mark.anyio
async def test_the_traffic_is_told_over_rest(house: House) -> None:
    lane = PLANT.lanes[0]
    now_s = 100.0
    house.bus.say(
        atv_heartbeat(seq=1, node=lane.start, at_s=now_s), atv_heartbeat(seq=2, node=lane.end, at_s=now_s)
    )
    answer = await house.get("/api/traffic")
    assert answer == {
        "window_s": WINDOW_S,
        "items": [{"start": lane.start, "end": lane.end, "passes": 1}],
    }
