"""A sketched plant is one that runs: no fault, and no warning that somebody new would have to understand first."""

from __future__ import annotations

import pytest
from variants import variants

from dray.plant import Plant, parse_plant, plant_yaml
from dray.plant.planning.advice import advice
from dray.plant.planning.sketch import Wishes, sketch


@pytest.mark.parametrize("machines", variants((1, 3, 40), 1, 40))
@pytest.mark.parametrize("vehicles", variants((1, 5, 40), 5))
def test_whatever_is_wished_for_has_no_fault(machines: int, vehicles: int) -> None:
    for products in (1, 9):
        file = sketch(Wishes(machines=machines, vehicles=vehicles, products=products))
        plant = parse_plant(plant_yaml(Plant(file)), "sketch")
        assert (len(plant.machines), len(plant.fleet), len(plant.products)) == (machines, vehicles, products)
        assert len(plant.dwell_points) >= vehicles
        kinds = {each.kind for each in advice(plant)}
        assert not kinds & {"dwell_points", "charger", "trap", "range"}, advice(plant)


def test_the_usual_one_has_nothing_to_be_warned_of() -> None:
    assert advice(Plant(sketch(Wishes()))) == []


def test_chargers_are_as_many_as_are_asked_for() -> None:
    assert len(sketch(Wishes(vehicles=4, chargers=3)).chargers) == 3
