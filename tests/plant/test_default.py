"""The default plant is the factory of the paper's Figure 1, and its numbers work out."""

from __future__ import annotations

import pytest

from dray.plant import Plant, default_plant

SECONDS_PER_HOUR = 3600.0


@pytest.fixture
def plant() -> Plant:
    return default_plant()


def test_it_has_the_parts_of_figure_1(plant: Plant) -> None:
    assert list(plant.machines) == [f"M{number}" for number in range(1, 13)]
    assert list(plant.fleet) == [f"ATV{number}" for number in range(1, 9)]
    assert len(plant.storages) == 8
    assert len(plant.chargers) == 6
    assert len(plant.parkings) == 8
    assert len(plant.products) == 4
    assert len(plant.areas) == 4
    assert (plant.width_m, plant.height_m) == (60, 40)


def test_every_working_station_has_three_machines(plant: Plant) -> None:
    for station in plant.stations:
        assert sum(machine.station == station for machine in plant.machines.values()) == 3


def test_the_source_is_bottom_left_and_the_delivery_top_right(plant: Plant) -> None:
    source, delivery = plant.warehouses["SOURCE"].box, plant.warehouses["DELIVERY"].box
    assert source.x_m < 0.1 * plant.width_m
    assert source.y_m < 0.25 * plant.height_m
    assert delivery.x_m > 0.9 * plant.width_m
    assert delivery.y_m > 0.75 * plant.height_m


def test_storages_and_chargers_stand_on_the_sides(plant: Plant) -> None:
    for spec in (*plant.storages.values(), *plant.chargers.values()):
        near_side = min(
            spec.box.x_m, plant.width_m - spec.box.x_m, spec.box.y_m, plant.height_m - spec.box.y_m
        )
        assert near_side < 3.0
    assert sum(storage.box.x_m < 5 for storage in plant.storages.values()) == 3
    assert sum(storage.box.y_m < 5 for storage in plant.storages.values()) == 3
    assert sum(storage.box.y_m > 35 for storage in plant.storages.values()) == 2
    assert sum(charger.box.x_m > 55 for charger in plant.chargers.values()) == 3
    assert sum(charger.box.y_m < 5 for charger in plant.chargers.values()) == 1
    assert sum(charger.box.y_m > 35 for charger in plant.chargers.values()) == 2


def test_machines_stand_in_the_centre_in_rows_of_three(plant: Plant) -> None:
    middles = [(machine.box.x_m, machine.box.y_m) for machine in plant.machines.values()]
    assert middles == [(x_m, y_m) for y_m in (31, 23.5, 16.5, 9) for x_m in (22, 32, 42)]


def test_a_docked_vehicle_stands_off_the_lanes(plant: Plant) -> None:
    for place in (*plant.machines, *plant.storages, *plant.dwell_points, "SOURCE"):
        spur = plant.roads.leaving[plant.node_of(place)]
        assert len(spur) == 1
        assert 1.5 <= spur[0].length_m <= 4.0


def test_a_vehicle_can_leave_the_delivery_while_another_comes(plant: Plant) -> None:
    dock = plant.node_of("DELIVERY")
    assert [lane.start for lane in plant.roads.entering[dock]] != [
        lane.end for lane in plant.roads.leaving[dock]
    ]


def test_nobody_stands_within_a_machine(plant: Plant) -> None:
    for machine in plant.machines.values():
        box = machine.box
        for node in plant.nodes.values():
            outside_x = abs(node.x_m - box.x_m) >= box.width_m / 2
            outside_y = abs(node.y_m - box.y_m) >= box.depth_m / 2
            assert outside_x or outside_y, f"{node.id} lies in {machine.id}"


def test_vehicles_stand_all_over_the_floor_on_a_dwell_point_of_their_own(plant: Plant) -> None:
    nodes = [vehicle.node for vehicle in plant.fleet.values()]
    assert set(nodes) <= {plant.node_of(dwell_point) for dwell_point in plant.dwell_points}
    places = [plant.nodes[node] for node in nodes]
    assert min(place.x_m for place in places) < 20
    assert max(place.x_m for place in places) > 40
    assert min(place.y_m for place in places) < 10
    assert max(place.y_m for place in places) > 30


def test_every_spot_of_the_floor_is_somebodys_area(plant: Plant) -> None:
    for x_m in range(61):
        for y_m in range(41):
            assert plant.areas_at(x_m, y_m)


def test_a_machine_and_its_dock_are_in_one_area(plant: Plant) -> None:
    for name, machine in plant.machines.items():
        areas = plant.areas_at(*plant.position_of(name))
        assert len(areas) == 1
        assert plant.areas_at(machine.box.x_m, machine.box.y_m) == areas


def test_every_material_is_kept_in_two_storages_and_every_product_made_by_three_machines(
    plant: Plant,
) -> None:
    assert min(len(plant.storages_of(material)) for material in plant.materials) >= 2
    assert min(len(plant.machines_for(product)) for product in plant.products) >= 3
    assert all(1 <= len(machine.makes) <= 3 for machine in plant.machines.values())
    assert all(2 <= len(product.bill) <= 4 for product in plant.products.values())


def test_half_of_the_fleet_can_carry_pallets(plant: Plant) -> None:
    able = [v for v in plant.fleet.values() if "pallet" in plant.vehicle_types[v.type].abilities]
    assert len(able) == 4
    assert {material for material in plant.materials if plant.ability_of(material) == "pallet"} == {
        "housing",
        "stator",
    }


def transports_per_hour(plant: Plant, machine: str) -> float:
    """Containers in and out, when a machine spends as much time on each of its products."""
    rates = []
    for making in plant.machines[machine].makes:
        product = plant.products[making.product]
        containers = 1 / product.lot + sum(
            line.quantity / plant.materials[line.material].lot for line in product.bill
        )
        rates.append(SECONDS_PER_HOUR / making.cycle_s * containers)
    return sum(rates) / len(rates)


def test_full_load_gives_100_to_120_transports_an_hour(plant: Plant) -> None:
    assert 100 <= sum(transports_per_hour(plant, machine) for machine in plant.machines) <= 120


def test_a_busy_vehicle_lasts_for_a_shift(plant: Plant) -> None:
    """`test_shipped` has the averages of real ones."""
    for kind in plant.vehicle_types.values():
        # Driving 80 of 120 seconds at two thirds of top speed, half of it loaded.
        metres_per_hour = SECONDS_PER_HOUR * 80 / 120 * kind.max_speed_mps * 2 / 3
        driving_w = metres_per_hour * (kind.drive_wh_per_m + kind.loaded_wh_per_m) / 2
        assert 9 <= kind.battery_wh / (driving_w + kind.idle_w) <= 12


def test_a_transport_takes_about_two_minutes(plant: Plant) -> None:
    for kind in plant.vehicle_types.values():
        routes = plant.routes(kind.id)
        durations_s = []
        for machine in plant.machines:
            for start in plant.dwell_points:
                approach = routes.duration_s(plant.node_of(start), plant.node_of("S4"))
                carry = routes.duration_s(plant.node_of("S4"), plant.node_of(machine))
                durations_s.append(approach + kind.load_s + carry + kind.unload_s)
        assert 75 <= sum(durations_s) / len(durations_s) <= 135
