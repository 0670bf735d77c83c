"""Plants that nobody here has drawn: one of a kind, none of a kind, many of a kind, lots of any size."""

from __future__ import annotations

from itertools import islice
from random import Random

import msgspec
import pytest
from plants import EXTREMES, plant_file

from dray.plant import Plant
from dray.plant.file.check import faults
from dray_sim.faults import play as begin_and_end
from dray_sim.faults import random_schedule
from dray_sim.insiders import BEHAVIOURS
from dray_sim.insiders.joining import bring_in
from dray_sim.people.demand import MAX_PIECES, orders
from dray_sim.people.habits import Habits
from dray_sim.plants.generator import generate_plant
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play

QUIET = Shift(name="any plant", duration_s=1800.0, load=0.3)
PEOPLED = Shift(name="any plant", duration_s=600.0, load=0.3, people=Habits())


@pytest.fixture(params=EXTREMES.values(), ids=EXTREMES)
def plant(request: pytest.FixtureRequest) -> Plant:
    return Plant(plant_file(**request.param))


def test_the_check_finds_no_fault_in_it(plant: Plant) -> None:
    assert list(faults(plant.file)) == []


def test_its_demand_asks_for_what_it_makes(plant: Plant) -> None:
    for order in islice(orders(plant, Random(1), load=0.6, until_s=float("inf")), 50):
        products = [item.product for item in order.items]
        assert set(products) <= set(plant.products)
        assert len(set(products)) == len(products)


@pytest.mark.parametrize("lot", [1, 3_333, 3_334, 10_000, 100_000])
def test_no_order_asks_for_more_than_a_gateway_takes(lot: int) -> None:
    file = plant_file()
    product = msgspec.structs.replace(file.products[0], lot=lot)
    plant = Plant(msgspec.structs.replace(file, products=(product,)))
    for order in islice(orders(plant, Random(1), load=0.6, until_s=float("inf")), 20):
        assert all(1 <= item.quantity <= MAX_PIECES for item in order.items)


@pytest.mark.campaign
def test_it_is_played_with_people_and_faults(plant: Plant) -> None:
    async def fail_and_recover(stage: Stage) -> bool:
        schedule = random_schedule(plant, stage.random("faults"), 400.0, 2.0)
        begin_and_end(schedule, stage.faults)
        await stage.until_s(PEOPLED.duration_s)
        return True

    played = play(PEOPLED, plant, 1, fail_and_recover)
    assert (played.invariants, played.result) == (HELD, True)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in EXTREMES if kind != "many machines"])
def test_orders_are_delivered_in_it(kind: str) -> None:
    played = play(QUIET, Plant(plant_file(**EXTREMES[kind])), 1)
    assert played.invariants == HELD
    assert played.report.pieces_delivered > 0


@pytest.mark.parametrize(("machines", "vehicles"), [(1, 1), (1, 40), (40, 1), (2, 2)])
def test_a_generated_plant_of_any_size_has_no_fault(machines: int, vehicles: int) -> None:
    plant = generate_plant(7, machines, vehicles)
    assert list(faults(plant.file)) == []
    assert play(Shift(name="any plant", duration_s=300.0, load=0.3), plant, 1).invariants == HELD


@pytest.mark.parametrize("behaviour", ["bids-nothing", "betrays"])
def test_an_insider_finds_a_name_in_a_plant_that_has_its_own_ninth_vehicle(behaviour: str) -> None:
    file = plant_file(vehicles=2)
    fleet = (msgspec.structs.replace(file.fleet[0], id="ATV9"), file.fleet[1])

    async def join(stage: Stage) -> str:
        worker = bring_in(stage.factory, BEHAVIOURS[behaviour])
        return worker.agent.id

    played = play(PEOPLED, Plant(msgspec.structs.replace(file, fleet=fleet)), 1, join)
    assert played.invariants == HELD
    assert played.result not in (None, "ATV9")
