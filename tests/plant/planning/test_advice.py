"""What will starve is said before it does: one plant for each kind of warning, and a figure in each."""

from __future__ import annotations

import re

import pytest

from dray.plant import Plant, default_plant, load_plant, parse_plant
from dray.plant.planning.advice import Advice, advice
from dray.plant.planning.flow import REFILL_S, Flow
from dray_sim.plants.fleet_sizes import with_fleet
from dray_sim.plants.raster import draw_raster
from dray_sim.scenarios.paper.laboratory import only_on


def change(text: str, *changes: tuple[str, str]) -> Plant:
    for old, new in changes:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
        text = text.replace(old, new)
    return parse_plant(text, "changed.yaml")


def of_kind(plant: Plant, kind: str) -> list[Advice]:
    return [each for each in advice(plant) if each.kind == kind]


def fleet(*nodes: str) -> str:
    return "fleet:\n" + "".join(
        f"  - {{id: ATV{number}, type: light, node: {node}}}\n" for number, node in enumerate(nodes, 1)
    )


FIRST_FLEET = fleet("middle")


def test_the_default_plant_is_full_where_its_file_says() -> None:
    flow = Flow(default_plant())
    assert 100 <= 3600 * sum(stream.per_s for stream in flow.streams) <= 130
    assert advice(default_plant()) == []


def test_the_small_plant_is_told_that_its_only_vehicle_is_alone(small_text: str) -> None:
    [alone] = of_kind(change(small_text), "alone")
    assert "ATV1 alone of 1 carries tote" in alone.text


def test_fewer_dwell_points_than_vehicles(small_text: str) -> None:
    [dwell_points] = of_kind(
        change(small_text, (FIRST_FLEET, fleet("middle", "west", "east", "south"))), "dwell_points"
    )
    assert "2 dwell points (1 chargers, 1 parking places) for 4 vehicles: 2 without work" in dwell_points.text
    assert "add 2 parking places" in dwell_points.text


def test_a_fleet_that_finds_no_place_on_its_floor_is_an_error_with_the_number_that_it_bears() -> None:
    floor = draw_raster(27)
    [enough] = [each for each in advice(with_fleet(floor, 31)) if each.kind == "dwell_points"]
    [too_many] = [each for each in advice(with_fleet(floor, 34)) if each.kind == "dwell_points"]
    assert (enough.level, too_many.level) == ("warning", "error")
    assert "the floor bears 31 vehicles at most" in too_many.text
    assert "take 3 vehicles away" in too_many.text
    assert "at most" not in enough.text


def test_the_reserve_of_a_fleet_is_named() -> None:
    [dwell_points] = [each for each in advice(draw_raster(17)) if each.kind == "dwell_points"]
    assert dwell_points.level == "warning"
    assert "8 are a reserve, which takes no work that others can do" in dwell_points.text


def test_the_reserve_counts_for_no_carriers() -> None:
    """In raster 38 all vehicles are of one type, 10 of 28 are a reserve, and 18 carry what 18 without a reserve do."""
    floor = draw_raster(38)
    [large, enough] = [
        next(limit for limit in Flow(plant).limits() if limit.kind == "vehicles")
        for plant in (floor, with_fleet(floor, 18))
    ]
    assert len(floor.fleet) - floor.spare_places.reserve_size == 18
    assert with_fleet(floor, 18).spare_places.reserve_size == 0
    assert large.load_frac == pytest.approx(enough.load_frac)
    assert large.remedy == "add 10 parking places"
    assert "18 that carry" in large.name


def test_as_many_dwell_points_as_vehicles_are_enough(small_text: str) -> None:
    assert of_kind(change(small_text, (FIRST_FLEET, fleet("middle", "west"))), "dwell_points") == []


CHARGER = "  - {id: CH1, node: west, box: {x_m: 5, y_m: 5, width_m: 2, depth_m: 2}}"


def with_battery(text: str, battery_wh: float, *more: tuple[str, str]) -> Plant:
    light = "{id: light, name: Light carrier}"
    return change(text, (light, f"{light[:-1]}, battery_wh: {battery_wh}}}"), *more)


def test_a_battery_too_small_for_a_transport(small_text: str) -> None:
    nodes = ("west", "east", "north", "south")
    more = "\n".join(
        CHARGER.replace("1, node: west", f"{n}, node: {node}") for n, node in enumerate(nodes, 1)
    )
    [reach] = of_kind(with_battery(small_text, 2.0, (CHARGER, more)), "range")
    assert re.search(r"takes \d+% of a battery of which 80% can be used", reach.text)
    assert reach.level == "warning"


def test_a_battery_that_never_lasts_for_a_transport_is_an_error_and_one_that_just_does_is_not(
    small_text: str,
) -> None:
    [never] = of_kind(with_battery(small_text, 3.9), "range")
    assert never.level == "error"
    assert never.text.startswith(
        "no vehicle ever carries gear from M1 to DELIVERY: with the way from a charger"
    )
    assert "it takes 103% of a full battery" in never.text
    assert of_kind(with_battery(small_text, 4.1), "range") == []


def test_a_storage_that_cannot_feed_its_machine(small_text: str) -> None:
    plant = change(small_text, ("capacity: 100", "capacity: 20"), ("cycle_s: 30", "cycle_s: 4"))
    [material] = of_kind(plant, "material")
    # Half a piece a second is used. 20 are there, leave when a vehicle has come for them, and are back REFILL_S later.
    [shafts] = [stream for stream in Flow(plant).streams if stream.item == "shaft"]
    assert 0.0 < shafts.fetch_s < shafts.lead_s
    limit = 20 / (REFILL_S + shafts.fetch_s) / 0.5
    assert material.load_frac == pytest.approx(limit, rel=0.01)
    assert limit < 1 / 3
    assert material.text.startswith(f"shaft is used {1 / limit:.1f} times as fast as storages are refilled")


def test_what_carriers_take_long_to_fetch_is_refilled_the_later(small_text: str) -> None:
    quick, slow = (
        change(
            small_text,
            ("capacity: 100", "capacity: 20"),
            ("cycle_s: 30", "cycle_s: 4"),
            ("{id: light, name: Light carrier}", f"{{id: light, name: Light carrier, load_s: {load_s}}}"),
        )
        for load_s in (10, 110)
    )
    [sooner], [later] = of_kind(quick, "material"), of_kind(slow, "material")
    assert 1 / later.load_frac - 1 / sooner.load_frac == pytest.approx(100 * 0.5 / 20)


def test_a_dock_at_which_vehicles_queue(small_text: str) -> None:
    plant = change(
        small_text, ("{id: light, name: Light carrier}", "{id: light, name: Light carrier, unload_s: 900}")
    )
    [dock] = [each for each in of_kind(plant, "dock") if " M1 " in each.text]
    assert dock.field == "machines"
    assert dock.load_frac < 1.0


def test_more_to_carry_than_one_vehicle_can(small_text: str) -> None:
    plant = change(small_text, ("cycle_s: 30", "cycle_s: 5"))
    [vehicles] = of_kind(plant, "vehicles")
    assert "1 that carry tote" in vehicles.text
    asks = float(re.search(r"([\d.]+) times", vehicles.text)[1])  # type: ignore[index]
    assert vehicles.load_frac == pytest.approx(1 / asks, rel=0.05)
    three = change(small_text, ("cycle_s: 30", "cycle_s: 5"), (FIRST_FLEET, fleet("middle", "west", "east")))
    [fewer] = of_kind(three, "vehicles")
    assert fewer.load_frac == pytest.approx(3 * vehicles.load_frac, rel=0.01)


def test_a_buffer_that_is_empty_before_the_next_load_comes(small_text: str) -> None:
    plant = change(small_text, ("lot: 20, buffer: 60", "lot: 4, buffer: 6"))
    assert [each for each in of_kind(plant, "buffer") if each.text.startswith("shaft at M1")]
    assert of_kind(change(small_text), "buffer") == []


def test_a_node_that_can_be_entered_and_not_left(small_text: str) -> None:
    plant = change(
        small_text,
        (
            "  - {id: south, x_m: 20, y_m: 2}\n",
            "  - {id: south, x_m: 20, y_m: 2}\n  - {id: pit, x_m: 30, y_m: 20}\n",
        ),
        ("  - {start: middle, end: east,", "  - {start: east, end: pit}\n  - {start: middle, end: east,"),
    )
    trap = of_kind(plant, "trap")[0]
    assert trap.text == "pit can be entered and not left: add a lane that leads back"


def test_two_places_with_one_dock(small_text: str) -> None:
    plant = change(small_text, ("{id: P1, node: middle}", "{id: P1, node: north}"))
    before = [trap.text for trap in of_kind(change(small_text), "trap")]
    [trap] = [each.text for each in of_kind(plant, "trap") if each.text not in before]
    assert trap.startswith("M1 and P1 have one dock, north")


def test_a_product_that_one_of_many_machines_makes() -> None:
    plant = only_on("motor-e4", "M10")
    assert [each.text for each in of_kind(plant, "machine") if each.text.startswith("M10 is full")]


def test_what_is_full_below_the_load_that_is_asked_for_is_an_error() -> None:
    plant = load_plant("workshop")
    fullest = Flow(plant).limits()[0]
    over = [each for each in advice(plant, fullest.load_frac + 0.001) if each.level == "error"]
    assert [each.kind for each in over] == [fullest.kind]
    assert "cannot be served" in over[0].text
    assert not [each for each in advice(plant, fullest.load_frac - 0.01) if each.level == "error"]
    assert not [each for each in advice(plant) if each.level == "error"]
