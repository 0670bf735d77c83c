"""The plants that ship beside the default one: asked for by name, and without a warning."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from dray.errors import PlantError
from dray.plant import SHIPPED, Plant, is_shipped, load_plant, parse_plant, plant_yaml, with_machine
from dray.plant.model import VehicleType
from dray.plant.planning.advice import advice
from dray_sim.bodies.vehicle.battery import Battery

NAMES = tuple(SHIPPED)


@pytest.fixture(params=NAMES)
def plant(request: pytest.FixtureRequest) -> Plant:
    return load_plant(request.param)


def test_a_shipped_plant_has_nothing_to_be_warned_of(plant: Plant) -> None:
    assert advice(plant) == []


def test_a_shipped_plant_is_the_same_when_it_is_written_and_read(plant: Plant) -> None:
    assert parse_plant(plant_yaml(plant), "again") == plant


def test_every_node_can_be_reached_from_every_other(plant: Plant) -> None:
    assert len(plant.roads.parts()) == 1


def test_every_vehicle_begins_on_a_dwell_point_of_its_own(plant: Plant) -> None:
    dwell_points = {plant.node_of(dwell_point) for dwell_point in plant.dwell_points}
    assert {vehicle.node for vehicle in plant.fleet.values()} <= dwell_points


def test_two_halls_are_joined_by_gates_in_one_direction_each() -> None:
    plant = load_plant("two-halls")
    gates = [
        (lane.start[0], lane.end[0]) for lane in plant.lanes if {lane.start[0], lane.end[0]} == {"w", "e"}
    ]
    assert sorted(gates) == [("e", "w"), ("w", "e")]


AVERAGE_HOURS, AVERAGE_CHARGING_HOURS = 8.4, 2.7
"""Published averages of AMRs; the file of the plant says where."""


@pytest.mark.parametrize("kind", load_plant("default").vehicle_types.values(), ids=lambda kind: kind.id)
def test_vehicles_of_the_default_plant_last_and_charge_as_long_as_amrs_do_on_average(
    kind: VehicleType,
) -> None:
    metre_wh = (kind.drive_wh_per_m + kind.loaded_wh_per_m) / 2
    at_work_w = kind.idle_w + 2 / 3 * kind.max_speed_mps * 3600 * metre_wh
    assert kind.battery_wh / at_work_w == pytest.approx(AVERAGE_HOURS, rel=0.05)
    assert Battery(kind).charging_s(0.0) / 3600 == pytest.approx(AVERAGE_CHARGING_HOURS, rel=0.05)


def test_the_default_plant_has_a_stop_point_between_any_two_crossings() -> None:
    plant = load_plant("default")
    assert all(len(crossing.nodes) == 1 for crossing in plant.crossings.values())
    assert len(plant.crossings) >= 50


def test_a_machine_that_joins_a_plant_with_two_lanes_can_be_driven_to() -> None:
    """Its dock is none as long as it is not there, and is no crossing then."""
    file = load_plant("default").file
    joining = file.machines[2]
    before = Plant(replace(file, machines=tuple(each for each in file.machines if each is not joining)))
    assert joining.node in before.stops
    assert with_machine(before, joining, "joining").driven.lanes == before.driven.lanes


def test_a_file_comes_before_a_shipped_plant_of_its_name(
    tmp_path: Path, small_text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert load_plant("workshop").id == "workshop"
    assert is_shipped("workshop")
    Path("workshop").write_text(small_text, encoding="utf-8")
    assert load_plant("workshop").id == "small"
    assert not is_shipped("workshop")


def test_who_asks_for_what_is_not_there_hears_what_is() -> None:
    with pytest.raises(PlantError, match="name one of default, workshop, two-halls, large, single-track"):
        load_plant("workshp")
