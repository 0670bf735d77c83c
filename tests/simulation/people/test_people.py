"""Operators: silent vehicles, who is where, and all of it in a running factory."""

from __future__ import annotations

import asyncio
from collections import Counter
from random import Random

import pytest
from people_floor import PLANT, QUICK, Floor, Story, play, trouble, until

from dray.messages import Brief, Phase, Role
from dray_sim.bodies.vehicle.condition import LOAD_SHIFTED
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Faults, LinkTrouble
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.areas import area_at
from dray_sim.people.crew import hire
from dray_sim.people.duty import Duty
from dray_sim.people.habits import Habits
from dray_sim.people.order_client import OrderClient

# --- silence ----------------------------------------------------------------------------------------


def silence(load: tuple[str, int] = ("", 0), *, off: bool = True, for_s: float = 200.0) -> Story:
    """A vehicle that carries for M8 is heard, and then no more."""

    async def story(floor: Floor) -> None:
        floor.puppet.task = Brief(
            task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8", phase=Phase.CARRYING
        )
        await asyncio.sleep(3.0)
        floor.puppet.silent, floor.hands.off, floor.hands.load = True, off, load
        await asyncio.sleep(for_s)

    return story


def test_a_silent_vehicle_is_cleared_up_and_brought_home() -> None:
    floor = play(silence(("P1", 5)))
    assert floor.deeds == ["unload", "put down", "bring home"]
    assert floor.hands.put == ("P1", 5, "n1", "M8")
    assert floor.hands.deeds[0][1] >= 3.0 + QUICK.silent_s + 1.0 + 10.0 - 1.0
    assert floor.operator.done[Duty.RECOVER] == 1


def test_an_empty_one_is_brought_home_at_once() -> None:
    assert play(silence()).deeds == ["unload", "bring home"]


def test_a_silent_vehicle_whose_lights_are_on_is_left_alone_until_it_is_heard_again() -> None:
    floor = play(silence(off=False, for_s=1000.0))
    assert floor.deeds == []
    assert floor.operator.done[Duty.RECOVER] == 1


def test_a_vehicle_that_comes_back_by_itself_meanwhile_is_not_pushed_away() -> None:
    async def story(floor: Floor) -> None:
        await silence(("P1", 5), for_s=30.0)(floor)
        await until(lambda: floor.deeds == ["unload"])
        floor.hands.off = floor.puppet.silent = False
        await asyncio.sleep(100.0)

    assert play(story).deeds == ["unload", "put down"]


# --- chance -----------------------------------------------------------------------------------------


def test_chance_follows_from_the_seed_alone() -> None:
    def moments(seed: int) -> list[tuple[str, float]]:
        return play(trouble(LOAD_SHIFTED), Habits(), seed=seed).hands.deeds

    assert moments(1) == moments(1)
    assert moments(1) != moments(2)


# --- areas ------------------------------------------------------------------------------------------


def test_every_point_has_one_area() -> None:
    assert area_at(PLANT, 30.0, 30.0) == "AREA1"
    assert area_at(PLANT, 30.0, 26.0) == "AREA1"
    assert area_at(PLANT, 30.0, 1000.0) == "AREA1"


def test_everybody_who_is_hired_has_an_area_and_a_name() -> None:
    async def main() -> list[str]:
        return [each.name for each in hire(SimFactory(PLANT, clock(), seed=1), seed=1)]

    assert run(main()) == [f"operator-{area}" for area in PLANT.areas]


# --- all of it in a running factory -----------------------------------------------------------------


async def _misfortunes(
    seed: int, turns: int = 12, *network: LinkTrouble
) -> tuple[SimFactory, Invariants, Counter[Duty]]:
    """A time in which loads shift and vehicles break or die, and people help."""
    listeners = Listeners()
    factory = SimFactory(PLANT, clock(), seed=seed, listener=listeners)
    checks = Invariants(factory)
    listeners.add(checks)
    faults = Faults(factory)
    for each in network:
        faults.begin(each)
    crew = hire(factory, seed=seed)
    orders = demand.orders(PLANT, Random(seed), load=0.9, until_s=1800.0)
    chance = Random(seed)
    async with asyncio.TaskGroup() as group:
        lives = [group.create_task(factory.run())]
        lives += [group.create_task(OrderClient(factory.bus, factory.clock).place(orders))]
        lives += [group.create_task(operator.run()) for operator in crew]
        await asyncio.sleep(200.0)
        for turn in range(turns):
            atv = chance.choice(list(factory.vehicles))
            if turn % 3 == 0:
                factory.vehicles[atv].break_down("blocked way")
            elif turn % 3 == 1:
                await until(lambda: any(each.shift_load() for each in factory.vehicles.values()))
            else:
                factory.power_off(atv)
            await asyncio.sleep(100.0)
        await asyncio.sleep(1200.0)
        for life in lives:
            life.cancel()
    checks.check_end(factory.clock.now_s())
    return factory, checks, sum((Counter(operator.done) for operator in crew), Counter())


def assert_all_is_well(factory: SimFactory) -> None:
    for vehicle in factory.vehicles.values():
        assert (vehicle.off, vehicle.problem, vehicle.sense().held) == (False, "", False)


@pytest.mark.slow
def test_people_bring_everything_back_to_life_and_no_piece_is_lost() -> None:
    factory, checks, done = run(_misfortunes(seed=5))
    assert_all_is_well(factory)
    assert done[Duty.HELP] >= 8
    assert done[Duty.RECOVER] >= 4
    assert sum(factory.in_hands.values()) == 0
    assert checks.broken is None


@pytest.mark.slow
def test_no_stop_outlives_its_operator_though_words_are_lost_doubled_and_overtaken() -> None:
    bad = LinkTrouble(latency_s=0.1, jitter_s=1.0, loss_frac=0.2, duplicate_frac=0.3, reorder_frac=0.5)
    factory, _, done = run(_misfortunes(3, 6, bad))
    assert_all_is_well(factory)
    assert done[Duty.SPEED_UP] >= 2, "more often when the vehicle has driven on into another area"
