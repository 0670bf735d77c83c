"""What a plant answers, and that it answers the same in every process."""

from __future__ import annotations

import pickle
from copy import deepcopy

import pytest
from hash_seeds import printed_by_each

from dray.plant import Plant, default_plant, parse_plant, plant_yaml


@pytest.fixture
def plant() -> Plant:
    return default_plant()


def test_a_place_is_where_vehicles_dock(plant: Plant) -> None:
    for place in (*plant.machines, *plant.storages, *plant.warehouses, *plant.dwell_points):
        node = plant.nodes[plant.node_of(place)]
        assert plant.position_of(place) == (node.x_m, node.y_m)


def test_a_vehicle_is_no_place(plant: Plant) -> None:
    with pytest.raises(KeyError):
        plant.node_of("ATV1")


def test_dwell_points_are_chargers_then_parking_places(plant: Plant) -> None:
    assert plant.dwell_points == (*plant.chargers, *plant.parkings)


def test_storages_of_a_material_keep_it(plant: Plant) -> None:
    for material in plant.materials:
        expected = [
            s.id for s in plant.storages.values() if material in {stock.material for stock in s.stocks}
        ]
        assert list(plant.storages_of(material)) == expected


def test_machines_for_a_product_make_it(plant: Plant) -> None:
    for product in plant.products:
        machines = plant.machines_for(product)
        assert machines
        assert all(plant.cycle_s(machine, product) > 0 for machine in machines)
        for other in plant.machines.keys() - set(machines):
            with pytest.raises(KeyError):
                plant.cycle_s(other, product)


def test_a_machine_needs_the_materials_of_all_that_it_makes(plant: Plant) -> None:
    assert plant.materials_of("M1") == ("housing", "shaft", "bearing")
    assert plant.materials_of("M10") == ("bearing", "seal-kit", "stator", "rotor")


def test_materials_and_products_have_lots_and_abilities(plant: Plant) -> None:
    assert (plant.materials["housing"].lot, plant.ability_of("housing")) == (24, "pallet")
    assert (plant.products["motor-e4"].lot, plant.ability_of("motor-e4")) == (20, "tote")


def test_warehouses_are_told_apart_by_what_they_are_for(plant: Plant) -> None:
    assert (plant.source_warehouses, plant.delivery_warehouses) == (("SOURCE",), ("DELIVERY",))


def test_no_two_points_are_farther_apart_than_the_diameter(plant: Plant) -> None:
    assert plant.diameter_m == pytest.approx(72.111, abs=1e-3)


def test_a_plant_cannot_be_changed(plant: Plant) -> None:
    with pytest.raises(TypeError):
        plant.machines["M13"] = plant.machines["M1"]  # type: ignore[index]
    with pytest.raises(AttributeError):
        plant.machines["M1"].name = "Other"  # type: ignore[misc]


def test_plants_of_one_file_are_equal(plant: Plant, small_text: str) -> None:
    twin = Plant(plant.file)
    assert (twin, hash(twin)) == (plant, hash(plant))
    assert plant != parse_plant(small_text, "small.yaml")
    assert plant != plant.file


def test_a_plant_travels_between_processes(plant: Plant) -> None:
    plant.routes("light").way("m1", "m12")
    for copy in (pickle.loads(pickle.dumps(plant)), deepcopy(plant)):
        assert copy == plant
        assert copy.routes("light").way("m1", "m12") == plant.routes("light").way("m1", "m12")


def test_a_plant_survives_being_written_and_read(plant: Plant, small_text: str) -> None:
    for original in (plant, parse_plant(small_text, "small.yaml")):
        assert parse_plant(plant_yaml(original), "copy.yaml") == original


@pytest.mark.slow
def test_every_process_gives_the_same_answers_in_the_same_order() -> None:
    script = (
        "from dray.plant import default_plant\n"
        "plant = default_plant()\n"
        "routes = plant.routes('light')\n"
        "print([plant.storages_of(m) for m in plant.materials], [plant.machines_for(p) for p in plant.products])\n"
        "print([plant.materials_of(m) for m in plant.machines], plant.cells_within(30, 20, 25))\n"
        "print([routes.way(a, b) for a in plant.nodes for b in plant.nodes])\n"
    )
    answers = printed_by_each(script)
    assert len(answers) == 1
    assert answers.pop()
