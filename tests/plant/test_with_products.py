"""A plant with other products: it answers as one that was made of its file alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import product as pairs

import msgspec
import pytest
from msgspec.structs import replace

from dray.plant import (
    BillLine,
    Door,
    LaneEnds,
    Plant,
    PlantFile,
    Product,
    default_plant,
    file_with_products,
    file_without_products,
)

DOORS = (
    Door("D1", "Gate", (LaneEnds("c1", "m11-lane"),), 10.0),
    Door("D2", "Other", (LaneEnds("a1", "b1"), LaneEnds("c2", "c3")), 5.0),
)

NEW = Product(id="frame", name="Frame", lot=4, bill=(BillLine("shaft", 1), BillLine("stator", 2)))


def two_lanes_with_doors() -> Plant:
    return Plant(replace(default_plant().file, doors=DOORS))


def with_a_new_one(file: PlantFile) -> PlantFile:
    return file_with_products(file, [(NEW, {"M1": 12.0, "M10": 15.0})])


def with_another_bill(file: PlantFile) -> PlantFile:
    known = file.products[0]
    changed = replace(known, bill=(BillLine("seal-kit", 1),), lot=known.lot + 1)
    return file_with_products(file, [(changed, {"M10": 20.0})])


def without_one(file: PlantFile) -> PlantFile:
    return file_without_products(file, [file.products[-1].id])


def of_another_ability(file: PlantFile) -> PlantFile:
    return file_with_products(file, [(replace(NEW, ability="crane"), {"M2": 9.0})])


def as_read_again(file: PlantFile) -> PlantFile:
    return msgspec.json.decode(msgspec.json.encode(file), type=PlantFile)


Change = Callable[[PlantFile], PlantFile]

CHANGES: Mapping[str, tuple[Change, ...]] = {
    "nothing": (),
    "a new one": (with_a_new_one,),
    "another bill": (with_another_bill,),
    "one less": (without_one,),
    "read again": (as_read_again,),
    "one after the other": (
        with_a_new_one,
        without_one,
        with_another_bill,
        of_another_ability,
        as_read_again,
    ),
    "there and back": (with_a_new_one, lambda file: file_without_products(file, [NEW.id])),
}


def told(value: object) -> object:
    """A value in its order, so that it can be compared."""
    if isinstance(value, Mapping):
        return list(value.items())
    if isinstance(value, Iterable) and not isinstance(value, str | set | frozenset):
        return list(value)
    return value


def each(names: Iterable[str], ask: Callable[[str], object]) -> list[object]:
    return [told(ask(name)) for name in names]


SHAPED = ((5.0, 5.0), (30.0, 5.0), (30.0, 20.0), (5.0, 20.0))

POINTS = ((1.0, 1.0), (20.0, 15.0), (55.5, 31.0))

LOOKUPS: Mapping[str, Callable[[Plant], object]] = {
    "ability_of": lambda p: each((*p.materials, *p.products, "nothing"), p.ability_of),
    "able": lambda p: each(p.abilities, p.able),
    "areas_at": lambda p: [p.areas_at(*point) for point in POINTS],
    "areas_near": lambda p: [p.areas_near(*point, 3.0) for point in POINTS],
    "cell_of": lambda p: [p.cell_of(*point) for point in POINTS],
    "cells_within": lambda p: [p.cells_within(*point, 25.0) for point in POINTS],
    "charger_queue": lambda p: [p.charger_queue.base_frac(kind) for kind in p.vehicle_types],
    "closest": lambda p: [p.closest(node, p.places, 4) for node in p.nodes],
    "crossing_of": lambda p: each(p.nodes, p.crossing_of),
    "cycle_s": lambda p: [p.cycle_s(m, product) for product in p.products for m in p.machines_for(product)],
    "extent_of": lambda p: each(p.areas, p.extent_of),
    "extent_within": lambda p: p.extent_within(SHAPED),
    "handling_cv": lambda p: [
        p.handling_cv(place, kind) for place, kind in pairs(p.places, p.vehicle_types.values())
    ],
    "has_place": lambda p: each((*p.places, "nowhere"), p.has_place),
    "is_in": lambda p: [p.is_in(*point, p.areas) for point in POINTS],
    "keepers_of": lambda p: each(p.materials, p.keepers_of),
    "keeps": lambda p: [p.keeps(place, material) for place, material in pairs(p.places, p.materials)],
    "machines_for": lambda p: each((*p.products, "nothing"), p.machines_for),
    "materials_of": lambda p: each(p.machines, p.materials_of),
    "node_of": lambda p: each(p.places, p.node_of),
    "places_on": lambda p: [p.places_on(lane.start, lane.end) for lane in p.lanes],
    "position_of": lambda p: each(p.places, p.position_of),
    "roads": lambda p: p.roads.lanes,
    "roads_of": lambda p: [p.roads_of(kind).lanes for kind in p.vehicle_types],
    "routes": lambda p: [
        p.routes(kind).way(start, goal)
        for kind in p.vehicle_types
        for start, goal in pairs(list(p.stops)[:3], repeat=2)
    ],
    "stand_of": lambda p: each((*p.dwell_points, *p.spare_places.all), p.stand_of),
    "storages_of": lambda p: each(p.materials, p.storages_of),
    "supplies_of": lambda p: each(p.materials, p.supplies_of),
    "uses": lambda p: [p.uses(m, item) for m, item in pairs(p.machines, (*p.materials, "nothing"))],
    "way_back": lambda p: [p.way_back(lane.start, lane.end) for lane in p.lanes],
    "with_products": lambda p: p.with_products(p.file).file,
    "working_time": lambda p: p.working_time.next_change_s(0.0),
    "working_time_of": lambda p: [p.working_time_of(m).next_change_s(0.0) for m in (*p.machines, "nothing")],
}
"""What is asked with something, or answers with an object of its own. All else is compared as it is."""


def lookups(plant: Plant) -> dict[str, object]:
    names = {name for name in (*dir(plant), *vars(plant)) if not name.startswith("_")}
    assert LOOKUPS.keys() <= names
    return {
        name: told(LOOKUPS.get(name, lambda p, name=name: getattr(p, name))(plant)) for name in sorted(names)
    }  # type: ignore[misc]


@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_it_answers_as_one_that_was_made_of_its_file(changes: tuple[Change, ...]) -> None:
    plant = two_lanes_with_doors()
    assert plant.driven.doors != plant.file.doors, "its roads have two lanes"
    for change in changes:
        plant = plant.with_products(change(plant.file))
    found, expected = lookups(plant), lookups(Plant(plant.file))
    assert all(not callable(value) for value in expected.values()), "each has its questions in LOOKUPS"
    for name, value in expected.items():
        assert found[name] == value, name


def test_it_shares_the_floor_and_its_ways() -> None:
    plant = two_lanes_with_doors()
    kind = next(iter(plant.vehicle_types))
    other = plant.with_products(with_a_new_one(plant.file))
    assert other.routes(kind) is plant.routes(kind)


ELSEWHERE: Mapping[str, Change] = {
    "doors": lambda file: replace(file, doors=file.doors[:1]),
    "nodes": lambda file: replace(file, nodes=(replace(file.nodes[0], x_m=1.5), *file.nodes[1:])),
    "cell_m": lambda file: replace(file, cell_m=2 * file.cell_m),
    "machines": lambda file: replace(
        file, machines=(replace(file.machines[0], node=file.machines[1].node), *file.machines[1:])
    ),
    "fleet": lambda file: replace(file, fleet=file.fleet[1:]),
}


@pytest.mark.parametrize("field", ELSEWHERE)
def test_a_file_that_differs_in_something_else_is_refused(field: str) -> None:
    plant = two_lanes_with_doors()
    with pytest.raises(ValueError, match=f"the plants differ in their {field}"):
        plant.with_products(ELSEWHERE[field](plant.file))


def test_one_machine_less_is_refused() -> None:
    plant = two_lanes_with_doors()
    with pytest.raises(ValueError, match="machines"):
        plant.with_products(replace(plant.file, machines=plant.file.machines[1:]))


def test_who_uses_an_item_is_who_makes_something_of_it() -> None:
    plant = two_lanes_with_doors().with_products(with_a_new_one(two_lanes_with_doors().file))
    for machine, material in pairs(plant.machines.values(), plant.materials):
        made = [plant.products[making.product] for making in machine.makes]
        needed = {line.material for product in made for line in product.bill}
        assert plant.uses(machine.id, material) == (material in needed)
        assert (material in plant.materials_of(machine.id)) == (material in needed)
        assert (machine.id in plant.keepers_of(material)) == (material in needed)
