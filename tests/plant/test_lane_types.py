"""Lanes for some types of vehicles only, and limits of their own: each type has roads of its own, and must get everywhere on them."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from dray.plant import Lane, Plant, PlantFile, load_plant
from dray.plant.file.check import faults
from dray.plant.model import LaneType
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.ways import Ways

LIGHT, HEAVY = "light", "heavy"


def square(*, both: tuple[LaneType, ...] = (), two_lanes: bool = False) -> PlantFile:
    """The default plant with one of its roads for some types only."""
    file = load_plant("default").file
    return replace(file, lanes=_with_types(file.lanes, ROAD, both), two_lanes=two_lanes)


def _with_types(lanes: tuple[Lane, ...], index: int, types: tuple[LaneType, ...]) -> tuple[Lane, ...]:
    return (*lanes[:index], replace(lanes[index], types=types), *lanes[index + 1 :])


def _on_many_ways() -> int:
    """A lane of the default plant that ways of vehicles lead over and that can be driven around."""
    file = load_plant("default").file
    for index, _ in enumerate(file.lanes):
        lanes = _with_types(file.lanes, index, (LaneType(LIGHT),))
        if not list(faults(replace(file, lanes=lanes))):
            return index
    raise AssertionError("every lane is the only way to somewhere")


ROAD = _on_many_ways()


def ends(file: PlantFile) -> tuple[str, str]:
    lane = file.lanes[ROAD]
    return lane.start, lane.end


def over(plant: Plant, kind: str) -> tuple[str, ...]:
    start, end = ends(plant.file)
    return plant.routes(kind).way(start, end).nodes


def test_a_lane_without_types_is_for_all() -> None:
    plant = load_plant("default")
    assert plant.roads_of(LIGHT) is plant.roads is plant.roads_of(HEAVY)


@pytest.mark.parametrize("way_of", ["routes", "right of way"])
def test_a_type_that_a_lane_is_not_for_drives_around_it(way_of: str) -> None:
    plant = Plant(square(both=(LaneType(LIGHT),)))
    start, end = ends(plant.file)

    def way(kind: str) -> tuple[str, ...]:
        if way_of == "routes":
            return over(plant, kind)
        found = Ways(plant, Places(plant), plant.vehicle_types[kind]).way(start, end)
        assert found is not None
        return found

    assert way(LIGHT) == (start, end)
    around = way(HEAVY)
    assert len(around) > 2
    assert (around[0], around[-1]) == (start, end)


def test_a_limit_of_a_type_holds_for_that_type_alone() -> None:
    free = Plant(square())
    start, end = ends(free.file)
    slow = Plant(square(both=(LaneType(HEAVY, 0.3), LaneType(LIGHT))))
    lane, own = slow.roads_of(LIGHT).lane(start, end), slow.roads_of(HEAVY).lane(start, end)
    assert lane is not None
    assert own is not None
    assert (lane.speed_limit_mps, own.speed_limit_mps) == (free.file.lanes[ROAD].speed_limit_mps, 0.3)
    assert slow.routes(LIGHT).duration_s(start, end) == free.routes(LIGHT).duration_s(start, end)
    assert slow.routes(HEAVY).duration_s(start, end) > free.routes(HEAVY).duration_s(start, end)


def test_a_limit_above_that_of_the_lane_changes_nothing() -> None:
    plant = Plant(square(both=(LaneType(HEAVY, 49.0), LaneType(LIGHT))))
    start, end = ends(plant.file)
    lane = plant.roads_of(HEAVY).lane(start, end)
    assert lane is not None
    assert lane.speed_limit_mps == plant.file.lanes[ROAD].speed_limit_mps


def test_a_road_of_two_lanes_is_for_its_types_up_to_both_of_its_stop_points() -> None:
    plant = Plant(square(both=(LaneType(HEAVY, 0.3), LaneType(LIGHT)), two_lanes=True))
    own = {
        (lane.start, lane.end)
        for lane in plant.roads_of(HEAVY).lanes
        if lane.speed_limit_mps == pytest.approx(0.3)
    }
    start, end = ends(plant.file)
    assert any(f"{start}.to-{end}" in pair or f"{end}.from-{start}" in pair for pair in own)
    assert any(f"{end}.to-{start}" in pair or f"{start}.from-{end}" in pair for pair in own)
    shut = Plant(square(both=(LaneType(LIGHT),), two_lanes=True))
    gone = {(lane.start, lane.end) for lane in shut.roads.lanes} - {
        (lane.start, lane.end) for lane in shut.roads_of(HEAVY).lanes
    }
    assert gone == own


def _one_dock_for_light(file: PlantFile) -> PlantFile:
    dock = file.machines[0].node
    at = [index for index, lane in enumerate(file.lanes) if dock in (lane.start, lane.end)]
    lanes = file.lanes
    for index in at:
        lanes = _with_types(lanes, index, (LaneType(LIGHT),))
    return replace(file, lanes=lanes)


def _unknown(file: PlantFile) -> PlantFile:
    return replace(file, lanes=_with_types(file.lanes, ROAD, (LaneType("hevy"), LaneType(LIGHT))))


def _twice(file: PlantFile) -> PlantFile:
    types = (LaneType(LIGHT), LaneType(HEAVY), LaneType(LIGHT, 1.0))
    return replace(file, lanes=_with_types(file.lanes, ROAD, types))


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (_one_dock_for_light, "heavy cannot get to"),
        (_unknown, "there is no hevy in `vehicle_types`: did you mean heavy?"),
        (_twice, "light is named twice"),
    ],
)
def test_lanes_whose_types_fit_together_badly_are_faults(
    spoil: Callable[[PlantFile], PlantFile], why: str
) -> None:
    told = [reason for _, reason in faults(spoil(load_plant("default").file))]
    assert len([reason for reason in told if why in reason]) == 1
