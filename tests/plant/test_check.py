"""Every mistake that a plant file can hold is named by its field, with what to do."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from dray.plant import parse_plant

Break = Callable[..., list[tuple[str, str]]]


def test_the_small_plant_has_no_faults(small_text: str) -> None:
    assert parse_plant(small_text, "small.yaml").id == "small"


SINGLE_FAULTS = {
    "a time zone that is none": (
        "name: Small plant",
        "name: Small plant\ntime_zone: Middle/Earth",
        "time_zone",
        "Middle/Earth is no time zone that is known: write its IANA name, as Europe/Berlin",
    ),
    "an area in which nobody ever is": (
        "    name: The floor\n",
        "    name: The floor\n    working_time: {shifts: [{start: '06:00', end: '14:00'}], breaks: [{start: '05:00', end: '15:00'}]}\n",
        "areas[0].working_time.breaks",
        "they leave nothing of its shifts: make them shorter",
    ),
    "a working time without working time": (
        "name: Small plant",
        "name: Small plant\nworking_time: {shifts: [{start: '06:00', end: '14:00'}], breaks: [{start: '05:00', end: '15:00'}]}",
        "working_time.breaks",
        "they leave nothing of its shifts: make them shorter",
    ),
    "a holiday that is no day": (
        "name: Small plant",
        "name: Small plant\nworking_time: {shifts: [{start: '06:00', end: '14:00'}], holidays: ['2026-02-30']}",
        "working_time.holidays[0]",
        "2026-02-30 is no day of any year: write one as 2026-12-25",
    ),
    "a shift at no time of day": (
        "name: Small plant",
        "name: Small plant\nworking_time: {shifts: [{start: '6:00', end: '14:00'}]}",
        "working_time.shifts[0].start",
        "",
    ),
    "a shift on no day of the week": (
        "name: Small plant",
        "name: Small plant\nworking_time: {shifts: [{start: '06:00', end: '14:00', days: [monday]}]}",
        "working_time.shifts[0].days[0]",
        "monday",
    ),
    "a vehicle that must charge while it need not": (
        "{id: light, name: Light carrier}",
        "{id: light, name: Light carrier, charging: {must_below_frac: 0.7}}",
        "vehicle_types[0].charging.below_frac",
        "0.6 is not 0.05 above `must_below_frac`, which is 0.7: raise this one or lower that one",
    ),
    "a charge that ends where it begins": (
        "{id: light, name: Light carrier}",
        "{id: light, name: Light carrier, charging: {below_frac: 0.9, up_to_frac: 0.92}}",
        "vehicle_types[0].charging.up_to_frac",
        "0.92 is not 0.05 above `below_frac`, which is 0.9",
    ),
    "quiet hours that are none": (
        "{id: light, name: Light carrier}",
        "{id: light, name: Light carrier, charging: {quiet_hours: [{start_h: 6, end_h: 6}]}}",
        "vehicle_types[0].charging.quiet_hours[0].end_h",
        "begin and end at 6: write 0 and 24 for the whole day",
    ),
    "quiet hours beyond the day": (
        "{id: light, name: Light carrier}",
        "{id: light, name: Light carrier, charging: {quiet_hours: [{start_h: 6, end_h: 25}]}}",
        "vehicle_types[0].charging.quiet_hours[0].end_h",
        "24",
    ),
    "a misspelt rule of charging": (
        "{id: light, name: Light carrier}",
        "{id: light, name: Light carrier, charging: {opportunities: true}}",
        "vehicle_types[0].charging",
        "opportunities",
    ),
    "two vehicles of one id": (
        "type: light, node: middle}\n",
        "type: light, node: middle}\n  - {id: ATV1, type: light, node: west}\n",
        "fleet[1].id",
        "ATV1 is the id of fleet[0] already",
    ),
    "a vehicle called like a machine": (
        "id: ATV1",
        "id: M1",
        "fleet[0].id",
        "M1 is the id of machines[0] already",
    ),
    "a machine that takes the strategist's name": (
        "id: M1\n",
        "id: Strategist\n",
        "machines[0].id",
        "is an agent of every plant",
    ),
    "a vehicle that takes the name of a second strategist": (
        "id: ATV1",
        "id: strategist2",
        "fleet[0].id",
        "is an agent of a plant with several strategists",
    ),
    "a vehicle that takes the name of the floor's certificate": (
        "id: ATV1",
        "id: floor",
        "fleet[0].id",
        "floor is the name of a certificate of every plant",
    ),
    "an unknown node": ("node: north\n", "node: nroth\n", "machines[0].node", "did you mean north?"),
    "an unknown node unlike any other": ("node: north\n", "node: q9\n", "machines[0].node", "add it there"),
    "an unknown end of a lane": ("end: east,", "end: aest,", "lanes[1].end", "there is no aest in `nodes`"),
    "an unknown material in a bill": (
        "{material: shaft, quantity: 2}",
        "{material: shafts, quantity: 2}",
        "products[0].bill[0].material",
        "did you mean shaft?",
    ),
    "an unknown station": (
        "station: WS1",
        "station: WS7",
        "machines[0].station",
        "there is no WS7 in `stations`",
    ),
    "an unknown vehicle type": ("type: light,", "type: lite,", "fleet[0].type", "there is no lite in"),
    "a lane that joins a node with itself": (
        "{start: middle, end: east, both_ways: true}",
        "{start: middle, end: east, both_ways: true}\n  - {start: east, end: east}",
        "lanes[2].end",
        "the lane joins east with itself",
    ),
    "a lane of no length": (
        "{id: north, x_m: 20, y_m: 25}",
        "{id: north, x_m: 20, y_m: 10}",
        "lanes[2]",
        "middle and north are 0 m apart",
    ),
    "a lane that is there already": (
        "lanes:\n",
        "lanes:\n  - {start: middle, end: west}\n",
        "lanes[1]",
        "lanes[0] leads from middle to west already",
    ),
    "a machine that cannot be reached": (
        "{start: middle, end: north, both_ways: true}",
        "{start: north, end: middle}",
        "machines[0].node",
        "M1 cannot be reached: no lanes lead from west to north",
    ),
    "a machine that cannot be left": (
        "{start: middle, end: north, both_ways: true}",
        "{start: middle, end: north}",
        "machines[0].node",
        "M1 cannot be left: no lanes lead from north to west",
    ),
    "a material that no storage keeps": (
        "buffer: 60}\n",
        "buffer: 60}\n  - {id: oil, name: Oil, lot: 1, buffer: 3}\n",
        "materials[1]",
        "no storage keeps oil",
    ),
    "a product that no machine makes": (
        "quantity: 2}]}\n",
        "quantity: 2}]}\n  - {id: axle, name: Axle, lot: 5, bill: [{material: shaft, quantity: 1}]}\n",
        "products[1]",
        "no machine makes axle",
    ),
    "an ability that no vehicle has": (
        "buffer: 60}",
        "buffer: 60, ability: crane}",
        "materials[0].ability",
        "no vehicle of the fleet can carry crane",
    ),
    "an ability that only a type without vehicles has": (
        "lot: 10, bill: [{material: shaft, quantity: 2}]}",
        "lot: 10, bill: [{material: shaft, quantity: 2}], ability: pallet}",
        "products[0].ability",
        "gear would never move",
    ),
    "a lot larger than the buffer": (
        "lot: 20, buffer: 60",
        "lot: 61, buffer: 60",
        "materials[0].lot",
        "a lot of 61 does not fit into a buffer of 60",
    ),
    "a bill larger than the buffer": (
        "quantity: 2}",
        "quantity: 61}",
        "products[0].bill[0].quantity",
        "61 pieces do not fit into the buffer of 60",
    ),
    "a bill that leaves no room for a lot": (
        "quantity: 2}",
        "quantity: 41}",
        "products[0].bill[0].quantity",
        "do not fit into the buffer of 60 together",
    ),
    "a material twice in one bill": (
        "[{material: shaft, quantity: 2}]",
        "[{material: shaft, quantity: 2}, {material: shaft, quantity: 1}]",
        "products[0].bill[1].material",
        "shaft is in this list already",
    ),
    "a material twice in one storage": (
        "[{material: shaft, capacity: 100}]",
        "[{material: shaft, capacity: 100}, {material: shaft, capacity: 40}]",
        "storages[0].stocks[1].material",
        "shaft is in this list already",
    ),
    "a product twice on one machine": (
        "[{product: gear, cycle_s: 30}]",
        "[{product: gear, cycle_s: 30}, {product: gear, cycle_s: 20}]",
        "machines[0].makes[1].product",
        "gear is in this list already",
    ),
    "a storage smaller than a lot": (
        "capacity: 100",
        "capacity: 19",
        "storages[0].stocks[0].capacity",
        "19 pieces are less than a lot of 20",
    ),
    "goods that never fill a lot": (
        "makes: [",
        "goods_capacity: 9\n    makes: [",
        "machines[0].goods_capacity",
        "9 pieces are less than the lot of 10 of gear",
    ),
    "a node beyond the floor": (
        "{id: east, x_m: 35,",
        "{id: east, x_m: 41,",
        "nodes[2]",
        "(41, 10) is outside of the floor of 40 m x 30 m",
    ),
    "a box beyond the floor": (
        "box: {x_m: 26, y_m: 25,",
        "box: {x_m: 39, y_m: 25,",
        "machines[0].box",
        "reaches beyond the floor",
    ),
    "an area beyond the floor": (
        "{x_m: 40, y_m: 30}",
        "{x_m: 40, y_m: 31}",
        "areas[0].polygon[2]",
        "(40, 31) is outside of the floor",
    ),
    "an area whose edges cross": (
        "{x_m: 40, y_m: 0}, {x_m: 40, y_m: 30}",
        "{x_m: 40, y_m: 30}, {x_m: 40, y_m: 0}",
        "areas[0].polygon",
        "the edges from corner 0 and from corner 2 cross",
    ),
    "an area that is closed by hand": (
        "{x_m: 0, y_m: 30}]",
        "{x_m: 0, y_m: 30}, {x_m: 0, y_m: 0}]",
        "areas[0].polygon[0]",
        "the polygon closes itself",
    ),
    "an area without an inside": (
        "{x_m: 40, y_m: 0}, {x_m: 40, y_m: 30}, {x_m: 0, y_m: 30}",
        "{x_m: 0.1, y_m: 0}, {x_m: 0, y_m: 0.1}",
        "areas[0].polygon",
        "it encloses nothing",
    ),
    "no delivery warehouse": ("kind: delivery", "kind: source", "warehouses", "products go nowhere"),
    "no source warehouse": ("kind: source", "kind: delivery", "warehouses", "material comes from nowhere"),
    "two vehicles on one spot": (
        "type: light, node: middle}\n",
        "type: light, node: middle}\n  - {id: ATV2, type: light, node: middle}\n",
        "fleet[1].node",
        "ATV1 stands at middle already",
    ),
    "a speed in kilometres per hour gone wild": (
        "speed_limit_mps: 0.8",
        "speed_limit_mps: 80",
        "lanes[3].speed_limit_mps",
        "80 is not within 0.05 to 50: check the unit",
    ),
    "a cycle of no time": (
        "cycle_s: 30",
        "cycle_s: 0.00001",
        "machines[0].makes[0].cycle_s",
        "check the unit",
    ),
    "cells as small as coins": (
        "height_m: 30\n",
        "height_m: 30\ncell_m: 0.1\n",
        "cell_m",
        "take larger ones",
    ),
}


@pytest.mark.parametrize(("old", "new", "field", "reason"), SINGLE_FAULTS.values(), ids=SINGLE_FAULTS)
def test_a_single_mistake_is_the_only_one_reported(
    broken: Break, old: str, new: str, field: str, reason: str
) -> None:
    found = broken((old, new))
    assert [name for name, _ in found] == [field]
    assert reason in found[0][1]


def test_a_product_may_not_be_called_like_a_material(broken: Break) -> None:
    twin = "  - {id: shaft, name: Axle, lot: 1, bill: [{material: shaft, quantity: 1}]}\n"
    found = broken(("products:\n", f"products:\n{twin}"))
    assert found[0] == ("products[0].id", "shaft is the id of materials[0] already: choose another")


def test_a_floor_in_millimetres_is_recognised(broken: Break) -> None:
    found = broken(("width_m: 40", "width_m: 40000"))
    assert found == [("width_m", "40000 m are more than 10000 m: write metres")]


def test_several_mistakes_are_all_reported_in_file_order(broken: Break) -> None:
    found = broken(
        ("type: light,", "type: lite,"),
        ("station: WS1", "station: WS2"),
        ("buffer: 60", "buffer: 10"),
        ("end: east,", "end: aest,"),
    )
    assert [field for field, _ in found] == [
        "lanes[1].end",
        "materials[0].lot",
        "machines[0].station",
        "fleet[0].type",
    ]


def test_what_follows_from_a_misspelt_name_is_not_reported_as_well(broken: Break) -> None:
    assert [field for field, _ in broken(("product: gear", "product: geer"))] == [
        "machines[0].makes[0].product"
    ]
    assert len(broken(("stocks: [{material: shaft", "stocks: [{material: shoft"))) == 1


def test_an_area_may_be_concave(small_text: str) -> None:
    notched = small_text.replace("{x_m: 40, y_m: 30},", "{x_m: 40, y_m: 30}, {x_m: 20, y_m: 10},")
    assert len(parse_plant(notched, "small.yaml").areas["FLOOR"].polygon) == 5


def test_an_area_of_very_many_corners_is_refused(broken: Break) -> None:
    corners = ", ".join(f"{{x_m: {k % 40}, y_m: {k % 29}}}" for k in range(201))
    found = broken(("{x_m: 0, y_m: 30}]", f"{{x_m: 0, y_m: 30}}, {corners}]"))
    assert found == [("areas[0].polygon", "205 corners are more than 200: draw it more simply")]
