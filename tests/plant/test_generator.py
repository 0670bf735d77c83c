"""Generated plants are valid, of the wanted size, and the same for the same seed."""

from __future__ import annotations

import pytest
from examples import examples
from hash_seeds import printed_by_each
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.errors import SettingsError
from dray.plant import Plant, default_plant, parse_plant, plant_yaml
from dray.plant.file.check import faults
from dray_sim.plants.generator import generate_plant


def density_m2(plant: Plant) -> float:
    """Floor per machine."""
    return plant.width_m * plant.height_m / len(plant.machines)


@settings(deadline=None, max_examples=examples(40))
@given(st.integers(0, 2**64), st.integers(1, 40), st.integers(1, 60))
def test_a_plant_of_any_size_has_no_faults(seed: int, machines: int, vehicles: int) -> None:
    plant = generate_plant(seed, machines, vehicles)
    assert list(faults(plant.file)) == []
    assert (len(plant.machines), len(plant.fleet)) == (machines, vehicles)


@settings(deadline=None, max_examples=examples(10))
@given(st.integers(0, 2**64), st.integers(1, 20), st.integers(1, 30))
def test_a_generated_plant_survives_being_written_and_read(seed: int, machines: int, vehicles: int) -> None:
    plant = generate_plant(seed, machines, vehicles)
    assert parse_plant(plant_yaml(plant), "generated.yaml") == plant


@pytest.mark.slow
def test_a_plant_of_200_machines_and_500_vehicles_is_read_back() -> None:
    plant = generate_plant(1, 200, 500)
    assert parse_plant(plant_yaml(plant), "generated.yaml") == plant
    assert len(plant.chargers) == 375
    assert len(plant.storages) == 134
    assert len(plant.delivery_warehouses) == 17


@pytest.mark.parametrize(("machines", "vehicles"), [(12, 8), (60, 40), (200, 134)])
def test_a_machine_has_as_much_floor_as_in_the_default_plant(machines: int, vehicles: int) -> None:
    plant = generate_plant(3, machines, vehicles)
    assert 0.6 < density_m2(plant) / density_m2(default_plant()) < 1.1


def test_the_same_seed_gives_the_same_plant() -> None:
    assert generate_plant(5, 30, 20) == generate_plant(5, 30, 20)
    assert generate_plant(5, 30, 20) != generate_plant(6, 30, 20)


def test_every_process_generates_the_same_plant() -> None:
    script = (
        "from dray.plant import plant_yaml\n"
        "from dray_sim.plants.generator import generate_plant\n"
        "print(plant_yaml(generate_plant(9, 7, 9)))\n"
    )
    assert len(printed_by_each(script)) == 1


def test_every_spot_of_the_floor_is_somebodys_area() -> None:
    plant = generate_plant(2, 30, 30)
    for x_m in range(int(plant.width_m) + 1):
        for y_m in range(int(plant.height_m) + 1):
            assert plant.areas_at(x_m, y_m)


def test_every_vehicle_has_a_parking_place_of_its_own() -> None:
    plant = generate_plant(4, 10, 25)
    parkings = {parking.node for parking in plant.parkings.values()}
    starts = {vehicle.node for vehicle in plant.fleet.values()}
    assert starts <= parkings
    assert len(starts) == 25


@pytest.mark.parametrize(("machines", "vehicles"), [(0, 1), (1, 0), (-3, 5), (2_001, 1), (1, 5_001)])
def test_a_size_out_of_range_is_refused(machines: int, vehicles: int) -> None:
    with pytest.raises(SettingsError, match="is not within 1 to"):
        generate_plant(1, machines, vehicles)
