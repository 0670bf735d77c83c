"""Plants that nobody here has drawn: any shape, the same for the same seed, judged by what they were promised."""

from __future__ import annotations

import pytest

from dray.messages import AtvHeartbeat, AtvStatus, Brief, Event, Phase, Pose, Role, TransportCost
from dray.messages.fact import BidReceived
from dray.plant import default_plant, parse_plant, plant_yaml
from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY
from dray_sim.plants.draw import draw_plant
from dray_sim.plants.many import play_seeds
from dray_sim.plants.play import draw
from dray_sim.plants.watch import Watch

SEEDS = range(40)


def test_every_seed_gives_a_plant_that_the_check_accepts() -> None:
    for seed in SEEDS:
        plant = draw_plant(seed, small=True)
        assert 2 <= len(plant.machines) <= 6
        assert 2 <= len(plant.fleet) <= 8


@pytest.mark.slow
def test_large_ones_too_and_they_are_of_many_kinds() -> None:
    plants = [draw_plant(seed) for seed in SEEDS]
    assert {len(plant.machines) > 20 for plant in plants} == {True, False}
    assert {len(plant.fleet) > 30 for plant in plants} == {True, False}
    both_ways = [all(plant.roads.lane(lane.end, lane.start) for lane in plant.lanes) for plant in plants]
    assert set(both_ways) == {True, False}
    dead_ends = [
        any(len(plant.roads.leaving[plant.node_of(place)]) == 1 for place in plant.machines)
        for plant in plants
    ]
    assert any(dead_ends)
    assert {len(plant.vehicle_types) for plant in plants} >= {1, 2, 3}
    assert any(len({storage.node for storage in p.storages.values()}) < len(p.storages) for p in plants)
    assert any("<b>" in plant.name for plant in plants)


def test_a_seed_gives_the_same_plant_and_the_same_demand() -> None:
    first, second = draw(7, "halls"), draw(7, "halls")
    assert first.plant == second.plant
    assert first.orders == second.orders
    assert draw(8, "halls").plant != first.plant


def test_the_demand_stays_below_what_the_plant_can_bear() -> None:
    for seed in SEEDS:
        run = draw(seed, "halls", small=True)
        assert 0.0 < run.load <= 0.6 * min(1.0, run.limit_load)
        assert run.orders


def test_what_is_drawn_survives_its_text() -> None:
    plant = draw_plant(3)
    assert parse_plant(plant_yaml(plant), "again") == plant


def beat(at_s: float, phase: Phase = Phase.LOADING, problem: str = "", task: str = "M1-1") -> AtvHeartbeat:
    return AtvHeartbeat(
        atv="ATV1",
        incarnation=1,
        seq=1,
        at_s=at_s,
        status=AtvStatus.ERROR if problem else AtvStatus.WORKING,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="s1",
        speed_mps=0.0,
        battery_frac=0.5,
        task=Brief(task=task, epoch=1, role=Role.PRIMARY, coordinator="M1", phase=phase, item="shaft"),
        problem=problem,
    )


def watched(*beats: AtvHeartbeat) -> Watch:
    watch = Watch(default_plant())
    cost = TransportCost(empty_way_s=1.0, loaded_way_s=1.0, energy_s=0.0, suitability_s=0.0)
    bid = BidReceived("M1-1", 1, Role.PRIMARY, 1, "ATV1", cost, 2.0, 100.0, "S1")
    watch.on_message(0.0, "M1", "event", Event(agent="M1", incarnation=1, number=1, at_s=0.0, fact=bid))
    for each in beats:
        watch.on_message(each.at_s, "ATV1", "hb", each)
    return watch


def test_a_carrier_that_stands_long_beyond_its_promise_is_seen() -> None:
    watch = watched(*(beat(float(at_s)) for at_s in range(50, 260, 5)))
    assert watch.waits == {("ATV1", "M1-1"): 155.0}
    assert (watch.longest.phase, watch.longest.beyond_s) == ("loading", 155.0)


def test_one_that_is_late_and_works_does_not_wait() -> None:
    assert watched(*(beat(float(at_s)) for at_s in range(230, 255, 5))).waits == {}


def test_a_wait_within_the_promise_and_two_minutes_is_none() -> None:
    assert watched(*(beat(float(at_s)) for at_s in range(0, 220, 5))).waits == {}


def test_a_flat_battery_is_seen() -> None:
    assert watched(beat(10.0, problem=BATTERY_EMPTY)).flat == {"ATV1": 10.0}


@pytest.fixture(scope="module")
def sample() -> list:
    """The small plants of four seeds, an hour each."""
    return list(play_seeds(0, 4, "halls", small=True, hours=1.0))


@pytest.mark.slow
def test_small_plants_are_served(sample: list) -> None:
    assert [(each.seed, each.failures) for each in sample if each.failures and not each.named] == []


@pytest.mark.campaign
def test_more_small_plants_are_served() -> None:
    more = play_seeds(4, 12, "halls", small=True, hours=1.0)
    assert [(each.seed, each.failures) for each in more if each.failures and not each.named] == []


@pytest.mark.slow
def test_another_play_of_a_seed_gives_the_same_figures(sample: list) -> None:
    [again] = play_seeds(0, 1, "halls", small=True, hours=1.0)
    first = sample[0]
    assert (again.transports, again.p95_s, again.settled_s) == (
        first.transports,
        first.p95_s,
        first.settled_s,
    )
    assert again.tell() == first.tell()
