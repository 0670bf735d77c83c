"""The plants that ship, and the one that is sketched from a few questions, deliver what is ordered."""

from __future__ import annotations

import pytest
from variants import in_campaigns

from dray.plant import Plant, load_plant
from dray.plant.planning.sketch import Wishes, sketch
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play

HOUR_S = 3600.0


@pytest.mark.parametrize(
    "name", in_campaigns(["workshop", "single-track", "two-halls", "large"], "workshop", "two-halls")
)
def test_a_shipped_plant_delivers_all_that_is_ordered_in_an_hour(name: str) -> None:
    plant = load_plant(name)

    async def work(stage: Stage) -> float:
        await stage.until_s(HOUR_S)
        return await stage.settle(HOUR_S)

    played = play(Shift(name="shipped", duration_s=HOUR_S, load=0.6), plant, 1, work)
    report = played.report
    assert report.invariants == HELD
    assert report.orders_placed >= 4
    assert report.orders_delivered == report.orders_placed
    assert report.starvation_frac < 0.05


def test_a_sketched_plant_delivers() -> None:
    plant = Plant(sketch(Wishes()))

    async def work(stage: Stage) -> float:
        await stage.until_s(3600.0)
        return await stage.settle(3600.0)

    report = play(Shift(name="sketch", duration_s=3600.0, load=0.9), plant, 1, work).report
    assert report.invariants == HELD
    assert report.orders_delivered == report.orders_placed >= 2


def test_in_the_laboratory_the_vehicle_that_carries_leaves_its_charging_station() -> None:
    plant = load_plant("laboratory")
    nodes = {vehicle.id: vehicle.node for vehicle in plant.file.fleet}
    assert nodes["ATV3"] in {charger.node for charger in plant.file.chargers}
    assert [machine.id for machine in plant.file.machines] == ["M8"]
    assert len({vehicle.type for vehicle in plant.file.fleet}) == 1
