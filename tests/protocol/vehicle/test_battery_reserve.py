"""What must be left in a battery, and from where a vehicle that rests comes to a charger in time."""

from __future__ import annotations

import msgspec
import pytest
from defaults import PLANT

from dray.plant import Plant
from dray.plant.charger_queue import SPARE_FRAC
from dray.protocol.vehicle.battery_reserve import NEVER_FRAC, BatteryReserve

SMALL = Plant(
    msgspec.structs.replace(
        PLANT.file,
        vehicle_types=tuple(
            msgspec.structs.replace(kind, battery_wh=12.0) for kind in PLANT.file.vehicle_types
        ),
    )
)
"""The default plant with batteries that last for minutes."""


def to_charger_s(node: str) -> float:
    return min(SMALL.routes("light").duration_s(node, SMALL.node_of(each)) for each in SMALL.chargers)


BY_CHARGER, FAR = min(sorted(SMALL.stops), key=to_charger_s), max(sorted(SMALL.stops), key=to_charger_s)
"""The nodes from which the way to a charger is shortest and longest."""


def without_ways_from(node: str) -> Plant:
    lanes = tuple(lane for lane in PLANT.file.lanes if node not in (lane.start, lane.end))
    return Plant(msgspec.structs.replace(PLANT.file, lanes=lanes))


def used_frac(start: str, end: str) -> float:
    way = SMALL.routes("light").way(start, end)
    return SMALL.charger_queue.way_frac("light", way.length_m, way.duration_s) - SPARE_FRAC


def test_where_no_charger_can_be_reached_nothing_is_promised() -> None:
    alone = BatteryReserve(without_ways_from("a1"), "light")
    assert alone.needed_frac("a1") == NEVER_FRAC
    assert alone.nearest_charger("a1") == ""


def test_the_nearest_charger_is_that_with_the_shortest_way() -> None:
    routes = SMALL.routes("light")
    nearest = min((SMALL.node_of(each) for each in SMALL.chargers), key=lambda at: routes.duration_s(FAR, at))
    assert BatteryReserve(SMALL, "light").nearest_charger(FAR) == nearest


@pytest.mark.parametrize(("more_frac", "rests"), [(0.001, True), (-0.001, False)])
def test_a_vehicle_rests_where_it_still_comes_to_a_charger_from(more_frac: float, rests: bool) -> None:
    reserve = BatteryReserve(SMALL, "light")
    just_frac = used_frac(BY_CHARGER, FAR) + reserve.needed_frac(FAR)
    assert reserve.is_enough_after(BY_CHARGER, FAR, just_frac + more_frac) is rests


def test_with_too_little_left_it_rests_where_it_is_nearer_to_a_charger_than_now() -> None:
    reserve = BatteryReserve(SMALL, "light")
    assert reserve.is_enough_after(FAR, BY_CHARGER, 0.0)
    assert reserve.is_enough_after(FAR, FAR, 0.0)
    assert not reserve.is_enough_after(BY_CHARGER, FAR, 0.0)


def test_where_no_way_leads_to_a_charger_any_place_is_good() -> None:
    alone = BatteryReserve(without_ways_from("a1"), "light")
    assert alone.is_enough_after("a1", "a1", 0.1)
