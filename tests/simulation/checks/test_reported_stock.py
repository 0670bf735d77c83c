"""A station orders no more than finds room; an order of an earlier life that it hears of again is none of its own."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext

import pytest

from dray.messages import StationHeartbeat, StockLevel, TaskBrief
from dray.plant import load_plant
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.reported_stock import WRONG_LEVEL_S, ReportedStock
from dray_sim.clock.loop import VirtualClock
from dray_sim.controllers.wired import WiredBodies
from dray_sim.factory.sim_factory import SimFactory

FULL, LOT = 400, 4
BEFORE, NEW = ("S1-refill-1", "S1.3-refill-1")


class Told:
    """What S1 tells a check."""

    def __init__(self) -> None:
        factory = SimFactory(load_plant("single-track"), VirtualClock(), seed=1)
        self._storage, self._check = factory.storages["S1"], ReportedStock(factory)
        self._at_s = 0.0

    def fills_to(self, pieces: int) -> None:
        """It fills itself up to this many pieces."""
        self._storage.filled["shaft"] = pieces
        self._storage.refills["shaft"] += 1

    def say(self, life: int, level: int, on_order: int, *tasks: str, beats: int = 1) -> None:
        """Its heartbeat of a life, with its tasks of one lot each."""
        for _ in range(beats):
            self._at_s += 1.0
            self._check.on_message(self._at_s, "S1", "*", heartbeat(life, self._at_s, level, on_order, tasks))


def heartbeat(life: int, at_s: float, level: int, on_order: int, tasks: Sequence[str]) -> StationHeartbeat:
    briefs = tuple(
        TaskBrief(
            task=task, epoch=1, item="shaft", quantity=LOT, source="S3", destination="S1", deadline_s=900.0
        )
        for task in tasks
    )
    return StationHeartbeat(
        station="S1",
        incarnation=life,
        seq=int(at_s),
        at_s=at_s,
        stocks=(StockLevel(item="shaft", level=level, capacity=FULL, on_order=on_order),),
        tasks=briefs,
    )


def forgotten() -> Told:
    """Its first life ordered a lot while there was room, and the next ones know nothing of it; all room is filled up."""
    told = Told()
    told.say(1, FULL - LOT, 0)
    told.say(1, FULL - LOT, LOT, BEFORE)
    told.say(2, FULL, 0, beats=2)
    told.say(3, FULL, 0, beats=2)
    return told


def test_an_order_of_two_lives_before_that_its_carrier_tells_of_is_no_new_one() -> None:
    told = forgotten()
    told.say(3, FULL, 0, BEFORE)
    told.say(3, FULL, LOT, BEFORE)
    with pytest.raises(InvariantBroken, match="S1 has 400 shaft and 8 on order"):
        told.say(3, FULL, 2 * LOT, BEFORE, NEW)


def test_an_order_that_finds_no_room_is_found_though_an_earlier_one_was_forgotten() -> None:
    told = forgotten()
    with pytest.raises(InvariantBroken, match="S1 has 400 shaft and 4 on order"):
        told.say(3, FULL, LOT, NEW)


def test_what_a_life_knows_from_its_journal_leaves_no_room_for_more() -> None:
    told = Told()
    told.say(1, FULL - LOT, LOT, BEFORE)
    told.say(2, FULL - LOT, LOT, BEFORE)
    with pytest.raises(InvariantBroken, match="S1 has 396 shaft and 8 on order"):
        told.say(2, FULL - LOT, 2 * LOT, BEFORE, NEW)


@pytest.mark.parametrize("stands", [True, False])
def test_a_level_that_no_rest_lets_count_is_no_wrong_report(*, stands: bool) -> None:
    plant, clock = load_plant("single-track"), VirtualClock()
    factory = SimFactory(plant, clock, seed=1, bodies=WiredBodies(plant, clock))
    check = ReportedStock(factory)
    lies = factory.storages["S1"].sense().stock["shaft"]
    vehicle = next(iter(factory.vehicles.values()))
    if stands:
        vehicle.place_at(plant.node_of("S1"))
    check.on_message(0.0, "S1", "*", heartbeat(1, 0.0, lies - LOT, 0, ()))
    late_s = WRONG_LEVEL_S + 1.0
    with nullcontext() if stands else pytest.raises(InvariantBroken, match="S1 tells of"):
        check.on_message(late_s, "S1", "*", heartbeat(1, late_s, lies - LOT, 0, ()))


def test_the_time_in_which_a_station_was_down_is_no_wrong_report() -> None:
    plant, clock = load_plant("single-track"), VirtualClock()
    factory = SimFactory(plant, clock, seed=1, bodies=WiredBodies(plant, clock))
    check = ReportedStock(factory)
    less = factory.storages["S1"].sense().stock["shaft"] - LOT
    up_s = WRONG_LEVEL_S + 1.0
    check.on_message(0.0, "S1", "*", heartbeat(1, 0.0, less + LOT, 0, ()))
    check.on_message(up_s, "S1", "*", heartbeat(2, up_s, less, 0, ()))
    check.on_message(up_s + 1.0, "S1", "*", heartbeat(2, up_s + 1.0, less, 0, ()))
    late_s = up_s + WRONG_LEVEL_S + 1.0
    with pytest.raises(InvariantBroken, match="S1 tells of"):
        check.on_message(late_s, "S1", "*", heartbeat(2, late_s, less, 0, ()))


def test_a_storage_that_fills_up_the_room_of_an_order_is_found() -> None:
    told = Told()
    told.say(1, 100, LOT, BEFORE)
    told.fills_to(FULL - LOT)
    told.say(1, FULL - LOT, LOT, BEFORE)
    told.fills_to(FULL)
    with pytest.raises(InvariantBroken, match="S1 has filled itself to 400 shaft with 4 on order"):
        told.say(1, FULL, LOT, BEFORE)


def test_a_life_that_did_not_know_of_an_order_leaves_no_room_for_it() -> None:
    told = Told()
    told.say(1, 100, LOT, BEFORE)
    told.fills_to(FULL)
    told.say(2, FULL, LOT, BEFORE)
