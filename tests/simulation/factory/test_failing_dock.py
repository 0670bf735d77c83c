"""Docks at which no vehicle gets what lies there by the books: people are asked to look, and no vehicle pays for it."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import Literal

import pytest

from dray.messages import MachineHeartbeat, Reason
from dray.messages.fact import CarrierChanged, ContractorRated
from dray.plant import default_plant
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play

PLANT = default_plant()
PRODUCT, PIECES = "pump-p3", 24
MAKERS = tuple(
    machine for machine, spec in PLANT.machines.items() if PRODUCT in {each.product for each in spec.makes}
)
SHIFT = Shift(
    "failing docks",
    3600.0,
    stock_frac=(0.02, 0.15),
    keep=(CarrierChanged, ContractorRated, MachineHeartbeat),
)


@dataclass(frozen=True, slots=True)
class Told:
    """What was said of docks that failed until a person was asked to look."""

    fails_at: set[str]
    """Where people were asked to look."""
    charged: dict[str, float]
    """What vehicles pay for the first loads that people were asked about (s)."""
    stalled: list[str]
    """The vehicles that have lost their transports, in order."""
    delivered: bool


async def jammed(stage: Stage, places: tuple[str, ...], does: Literal["take", "put"]) -> Told:
    """One order; nothing is loaded, or put down, at these places until a person is asked to look there."""
    bodies = {**stage.factory.workcells, **stage.factory.storages}
    working = {place: getattr(bodies[place], does) for place in places}
    for place in places:
        setattr(bodies[place], does, lambda *_asked: "the conveyor is jammed")
    stage.order(PRODUCT, PIECES)
    looked: dict[str, str] = {}
    while not looked:
        assert stage.now_s() < stage.shift.duration_s, "nobody is asked"
        await asyncio.sleep(1.0)
        briefs = [brief for seen in stage.witness.all(MachineHeartbeat) for brief in seen.said.tasks]
        looked = {each.task: each.fails_at for each in briefs if each.trouble is Reason.DISPUTED}
    charged: dict[str, float] = {}
    for seen in stage.witness.all(ContractorRated):
        if seen.said.task in looked:
            charged[seen.said.contractor] = seen.said.surcharge_s
    for place, works in working.items():
        setattr(bodies[place], does, works)
    await stage.settle(3600.0)
    changes = [seen.said for seen in stage.witness.all(CarrierChanged)]
    stalled = [each.replaced for each in changes if each.task in looked]
    return Told(set(looked.values()), charged, stalled, not stage.undelivered())


@pytest.mark.parametrize(
    ("places", "does"),
    [(MAKERS, "take"), (MAKERS, "put"), (tuple(PLANT.storages), "take")],
    ids=["goods are not given out", "material is not taken in", "storages give nothing out"],
)
def test_a_person_is_asked_to_look_where_two_vehicles_failed_and_then_the_order_is_delivered(
    places: tuple[str, ...], does: Literal["take", "put"]
) -> None:
    played = play(SHIFT, PLANT, 1, lambda stage: jammed(stage, places, does))
    assert played.invariants == HELD
    told = played.result
    assert told is not None
    assert told.fails_at <= set(places)
    assert len(told.stalled) == len(set(told.stalled)) >= 2
    assert set(told.charged.values()) == {0.0}
    assert told.delivered
