"""What a vehicle keeps in its battery for the way to a charger and for the queue there, and the plants that cannot feed theirs."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from random import Random

import pytest
from msgspec.structs import replace

from dray.plant import Charging, Parking, Plant, VehicleSpec, VehicleType, load_plant, parse_plant
from dray.plant.charger_queue import (
    LOOKS_AGAIN_S,
    RESERVE_FRAC,
    SPARE_FRAC,
    WORTH_FRAC,
    ChargerQueue,
    charging_s,
)
from dray.plant.file.check_power import power_faults
from dray.plant.file.file import SHIPPED
from dray.plant.planning.advice import advice
from dray_sim.bodies.vehicle.battery import Battery

THIRSTY = VehicleType(
    "light", "Light carrier", battery_wh=15.0, idle_w=25.0, charge_w=200.0, max_speed_mps=1.0
)
SMALL_BATTERY = "{id: light, name: Light carrier, battery_wh: 15, idle_w: 25, charge_w: 200}"
FLEET = "  - {id: ATV1, type: light, node: middle}\n"


def plant_of(text: str, vehicles: int = 3, kind: VehicleType = THIRSTY, chargers: int = 1) -> Plant:
    file = parse_plant(text, "small").file
    nodes = ("middle", "west", "east", "north", "south")
    fleet = tuple(VehicleSpec(f"ATV{n}", "light", nodes[n % len(nodes)]) for n in range(vehicles))
    more = tuple(replace(file.chargers[0], id=f"CH{n}") for n in range(1, chargers + 1))
    return Plant(replace(file, vehicle_types=(kind,), fleet=fleet, chargers=more))


def test_a_charge_takes_as_long_here_as_in_a_simulated_body() -> None:
    random = Random(1)
    for _ in range(200):
        kind = VehicleType(
            "t",
            "T",
            battery_wh=random.uniform(8.0, 2000.0),
            charge_w=random.uniform(50.0, 3000.0),
            charge_taper_frac=random.choice((0.5, 0.8, 1.0)),
        )
        low, high = sorted((random.random(), random.random()))
        assert charging_s(kind, low, high) == pytest.approx(Battery(kind).charging_s(low, high))
    assert charging_s(THIRSTY, 0.5, 0.5) == charging_s(THIRSTY, 0.6, 0.5) == 0.0


def test_who_has_a_charger_for_itself_keeps_the_usual_reserve_and_the_way(small_text: str) -> None:
    queue = plant_of(small_text, 1, VehicleType("light", "Light carrier")).charger_queue
    assert (queue.ahead, queue.wait_s) == (0, 0.0)
    assert queue.base_frac("light") == RESERVE_FRAC
    # 100 m at 0.03 Wh/m of 500 Wh.
    assert queue.needed_frac("light", 100.0, 60.0) == pytest.approx(RESERVE_FRAC + 0.006)


def test_who_leaves_with_what_is_needed_has_the_spare_left_after_way_and_queue(small_text: str) -> None:
    """The last of three drives, waits until two others were charged, and still has SPARE_FRAC."""
    queue = plant_of(small_text).charger_queue
    way_m, way_s = 40.0, 45.0
    spent_wh = way_m * THIRSTY.drive_wh_per_m + (way_s + queue.wait_s) * THIRSTY.idle_w / 3600.0
    left_frac = queue.needed_frac("light", way_m, way_s) - spent_wh / THIRSTY.battery_wh
    assert SPARE_FRAC <= left_frac < SPARE_FRAC + 0.1
    session_s = charging_s(THIRSTY, SPARE_FRAC, queue.enough_frac("light"))
    assert queue.wait_s >= 2 * (session_s + LOOKS_AGAIN_S)
    assert queue.enough_frac("light") == pytest.approx(queue.base_frac("light") + WORTH_FRAC)


def test_more_vehicles_at_a_charger_need_more_and_more_chargers_less(small_text: str) -> None:
    needed = [plant_of(small_text, vehicles).charger_queue.base_frac("light") for vehicles in (1, 2, 3)]
    assert needed == sorted(set(needed))
    two = plant_of(small_text, 3, chargers=2).charger_queue
    assert (two.ahead, two.base_frac("light") < needed[2]) == (1, True)


def test_many_chargers_share_a_queue(small_text: str) -> None:
    """Seven others at three chargers: at most two before the last one, whatever they take."""
    queue = plant_of(small_text, 8, replace(THIRSTY, battery_wh=100.0), chargers=3).charger_queue
    one = plant_of(small_text, 2, replace(THIRSTY, battery_wh=100.0)).charger_queue
    assert queue.ahead == ceil(8 / 3) - 1
    assert one.wait_s < queue.wait_s <= 2.2 * one.wait_s


def test_where_the_queue_has_no_end_vehicles_still_go_to_charge_in_time_to_be_charged(
    small_text: str,
) -> None:
    plant = plant_of(small_text, 8)
    queue = plant.charger_queue
    assert queue.starved == ("light",)
    rules = Charging()
    assert queue.base_frac("light") == rules.below_frac
    assert queue.enough_frac("light") <= rules.up_to_frac


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_plants_feed_their_vehicles(name: str) -> None:
    plant = load_plant(name)
    assert list(power_faults(plant)) == []
    assert all(plant.charger_queue.base_frac(kind) < 0.15 for kind in plant.vehicle_types)


def test_vehicles_that_use_more_than_is_charged_without_any_work_are_a_fault(
    broken: Callable[..., list[tuple[str, str]]],
) -> None:
    [(field, reason)] = broken(
        ("{id: light, name: Light carrier}", "{id: light, name: Light carrier, idle_w: 400, charge_w: 600}"),
        (
            FLEET,
            "".join(
                f"  - {{id: ATV{n}, type: light, node: {node}}}\n"
                for n, node in enumerate(("middle", "west", "east"))
            ),
        ),
    )
    assert field == "chargers"
    # Each is charged for 400 / (400 + 600) of its time.
    assert reason == (
        "1 charger for 3 vehicles: without any work they use 1.2 times what can be charged, and run flat: "
        "write 2 chargers at least, a lower `idle_w`, or fewer vehicles"
    )


def test_a_battery_that_does_not_last_for_the_queue_is_a_fault_and_what_helps_is_said(
    broken: Callable[..., list[tuple[str, str]]], small_text: str
) -> None:
    changes = (
        ("{id: light, name: Light carrier}", SMALL_BATTERY),
        (
            FLEET,
            "".join(
                f"  - {{id: ATV{n}, type: light, node: {node}}}\n"
                for n, node in enumerate(("middle", "west", "east", "north", "south"))
            ),
        ),
    )
    [(field, reason)] = broken(*changes)
    assert field == "chargers"
    assert reason.startswith("1 charger for 5 vehicles: light may wait ")
    assert reason.endswith("a higher `charge_w`, or fewer vehicles")
    plant = plant_of(small_text, 5)
    least = int(reason.partition("write ")[2].split()[0])
    kind = next(iter(plant.vehicle_types))
    assert ChargerQueue(plant, chargers=least).starved == ()
    assert ChargerQueue(plant, chargers=least).base_frac(kind) < plant.charger_queue.base_frac(kind)


def test_a_small_battery_that_lasts_for_the_queue_is_told_what_it_keeps(small_text: str) -> None:
    plant = plant_of(small_text)
    assert list(power_faults(plant)) == []
    [warning] = [each for each in advice(plant) if each.kind == "queue"]
    assert f"light stops working with {plant.charger_queue.base_frac('light'):.0%} left" in warning.text
    assert "while 2 others charge" in warning.text


def test_far_waiting_places_count(small_text: str) -> None:
    """Whoever waits far from the charger leaves earlier, for the way there and back."""
    near = plant_of(small_text)
    far = Plant(replace(near.file, parkings=(Parking("P1", "east"),)))
    assert far.charger_queue.base_frac("light") > near.charger_queue.base_frac("light")
