"""Plants with a raster of roads: what is drawn of each seed, and that nothing on it is too narrow."""

from __future__ import annotations

from typing import cast

from dray.plant import parse_plant, plant_yaml
from dray.plant.planning.room import room_faults
from dray.protocol.vehicle.atv import Atv
from dray_sim.plants.fleet_sizes import with_fleet
from dray_sim.plants.play import draw
from dray_sim.plants.raster import draw_raster
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play, with_right_of_way

SEEDS = range(30)


def test_every_seed_gives_a_plant_on_which_two_vehicles_have_room() -> None:
    for seed in SEEDS:
        plant = draw_raster(seed)
        assert 2 <= len(plant.machines) <= 40
        assert 2 <= len(plant.fleet) <= 45
        assert list(room_faults(plant)) == []


def test_they_are_of_many_kinds() -> None:
    plants = [draw_raster(seed) for seed in SEEDS]
    assert {len(plant.machines) > 12 for plant in plants} == {True, False}
    assert {len(plant.fleet) > len(plant.dwell_points) for plant in plants} == {True, False}
    assert any(len({each.node for each in one.storages.values()}) < len(one.storages) for one in plants)
    one_way = [any(one.roads.lane(lane.end, lane.start) is None for lane in one.lanes) for one in plants]
    assert set(one_way) == {True, False}
    in_lane = [any(one.node_of(place).startswith("l-") for place in one.machines) for one in plants]
    assert set(in_lane) == {True, False}


def test_a_seed_gives_the_same_plant_and_another_one_another() -> None:
    first, second = draw(5, small=True), draw(5, small=True)
    assert first.plant == second.plant
    assert first.orders == second.orders
    assert draw(6, small=True).plant != first.plant
    assert parse_plant(plant_yaml(first.plant), "again") == first.plant


def test_a_floor_is_given_as_many_vehicles_as_are_asked_for() -> None:
    plant = draw_raster(27)
    for count in (2, len(plant.fleet), 32):
        more = with_fleet(plant, count)
        assert len(more.fleet) == count
        assert len({spec.node for spec in more.fleet.values()}) == count
        kept = min(count, len(plant.fleet))
        assert tuple(more.file.fleet[:kept]) == tuple(plant.file.fleet[:kept])
        assert more.nodes == plant.nodes


def test_who_waits_in_the_reserve_takes_no_work_that_others_can_do() -> None:
    plant = draw_raster(28)
    assert plant.spare_places.reserve

    async def look(stage: Stage) -> tuple[set[str], list[str]]:
        reserve: set[str] = set()
        waited, called = set[str](), list[str]()
        while stage.now_s() < 1200.0:
            agents = {atv: cast(Atv, stage.factory.workers[atv].agent) for atv in plant.fleet}
            called += [atv for atv in reserve if agents[atv].is_busy]
            reserve = {atv for atv in agents if agents[atv].is_reserve(stage.now_s())}
            waited |= reserve
            await stage.until_s(stage.now_s() + 1.0)
        return waited, called

    with with_right_of_way(True):
        played = play(Shift(name="reserve", duration_s=1200.0, load=0.1), plant, 1, look)
    assert played.invariants == HELD
    assert played.report.transports > 5
    assert played.result is not None
    waited, called = played.result
    assert waited
    assert called == []
