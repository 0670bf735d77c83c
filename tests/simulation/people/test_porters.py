"""Porters: what somebody says of a vehicle that is carried is done with the simulated one."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from dray.plant import default_plant
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, gone_s
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Crashed, Faults, Partition, PoweredOff
from dray_sim.people.floor_office import FloorOffice
from dray_sim.people.porters import Porters

ATV, PERSON = "ATV3", "user:anna"

BELIEVED_S = gone_s(IDLE_INTERVAL_S) + 5.0

Script = Callable[[SimFactory, Faults, FloorOffice], Awaitable[None]]


def play(script: Script) -> None:
    """Let a factory with right of way run for as long as a script takes."""

    async def live() -> None:
        factory = SimFactory(default_plant(), clock(), seed=1, traffic=True)
        faults = Faults(factory)
        Porters(factory, faults)
        office = FloorOffice(factory.bus, factory.clock, factory.keys, factory.authority)
        living = [asyncio.create_task(factory.run()), asyncio.create_task(office.run())]
        await asyncio.sleep(5.0)
        await script(factory, faults, office)
        for task in living:
            task.cancel()
        await asyncio.gather(*living, return_exceptions=True)

    run(live(), JUMP)


def free_place(factory: SimFactory) -> str:
    """The node of a parking place where nobody is."""
    plant = factory.plant
    taken = {*factory.held_places(), *(each.sense().node for each in factory.vehicles.values())}
    return next(plant.node_of(place) for place in plant.parkings if plant.node_of(place) not in taken)


def test_a_vehicle_stands_where_a_person_says_that_it_is_put() -> None:
    async def script(factory: SimFactory, faults: Faults, office: FloorOffice) -> None:
        vehicle, stood, place = factory.vehicles[ATV], factory.vehicles[ATV].sense().node, free_place(factory)
        fault = faults.begin(PoweredOff(ATV))
        await asyncio.sleep(BELIEVED_S)
        assert ATV not in factory.floor.lifted
        office.carry_away(ATV, PERSON)
        await asyncio.sleep(BELIEVED_S)
        assert ATV in factory.floor.lifted
        assert await office.put_back(ATV, place, PERSON)
        await asyncio.sleep(1.0)
        assert ATV not in factory.floor.lifted
        assert vehicle.sense().node == place != stood
        # Who has switched it off has not switched it on again.
        assert not factory.running(ATV)
        faults.end(fault)
        await asyncio.sleep(30.0)
        assert factory.running(ATV)
        assert vehicle.sense().node == place
        assert office.heard[ATV].node == place
        assert {held for held, who in factory.held_places().items() if who == ATV} == {place}

    play(script)


def test_one_that_was_mended_while_it_was_away_goes_on_when_it_is_put_back() -> None:
    async def script(factory: SimFactory, faults: Faults, office: FloorOffice) -> None:
        place = free_place(factory)
        fault = faults.begin(PoweredOff(ATV))
        office.carry_away(ATV, PERSON)
        await asyncio.sleep(2 * BELIEVED_S)
        faults.end(fault)
        await asyncio.sleep(5.0)
        assert not factory.running(ATV)
        assert await office.put_back(ATV, place, PERSON)
        await asyncio.sleep(5.0)
        assert factory.running(ATV)
        assert factory.vehicles[ATV].sense().node == place

    play(script)


def test_one_whose_process_has_ended_is_switched_off_to_be_carried_and_on_again_when_it_stands() -> None:
    async def script(factory: SimFactory, faults: Faults, office: FloorOffice) -> None:
        place = free_place(factory)
        fault = faults.begin(Crashed(ATV))
        office.carry_away(ATV, PERSON)
        await asyncio.sleep(2 * BELIEVED_S)
        assert factory.vehicles[ATV].off
        assert await office.put_back(ATV, place, PERSON)
        await asyncio.sleep(5.0)
        assert not factory.vehicles[ATV].off
        assert not factory.running(ATV)
        faults.end(fault)
        await asyncio.sleep(5.0)
        assert factory.running(ATV)
        assert factory.vehicles[ATV].sense().node == place

    play(script)


def test_nobody_carries_a_vehicle_that_is_heard() -> None:
    async def script(factory: SimFactory, _faults: Faults, office: FloorOffice) -> None:
        office.carry_away(ATV, PERSON)
        await asyncio.sleep(2 * BELIEVED_S)
        assert ATV not in factory.floor.lifted
        assert factory.running(ATV)

    play(script)


def test_whoever_speaks_by_the_floor_office_uses_hands_of_its_own() -> None:
    async def script(factory: SimFactory, faults: Faults, office: FloorOffice) -> None:
        faults.begin(PoweredOff(ATV))
        office.carry_away(ATV)
        await asyncio.sleep(2 * BELIEVED_S)
        assert ATV not in factory.floor.lifted

    play(script)


def test_one_that_was_heard_last_while_the_office_was_cut_off_is_lifted_and_put_back() -> None:
    """The machines have heard later heartbeats of it than the office names, and all of them before the report."""

    async def script(factory: SimFactory, faults: Faults, office: FloorOffice) -> None:
        place = free_place(factory)
        cut_off = faults.begin(Partition(groups=((ATV, "M*"),)))
        await asyncio.sleep(20.0)
        fault = faults.begin(PoweredOff(ATV))
        await asyncio.sleep(5.0)
        faults.end(cut_off)
        await asyncio.sleep(BELIEVED_S)
        office.carry_away(ATV, PERSON)
        await asyncio.sleep(5.0)
        assert ATV in factory.floor.lifted
        assert await office.put_back(ATV, place, PERSON)
        faults.end(fault)

    play(script)


def test_one_that_drove_on_after_a_wrong_report_keeps_its_places() -> None:
    """The office was cut off from it, and a person took it for another one; it falls silent later."""

    async def script(factory: SimFactory, faults: Faults, office: FloorOffice) -> None:
        cut_off = faults.begin(Partition(groups=((ATV, "M*"),)))
        await asyncio.sleep(2.0)
        office.carry_away(ATV, PERSON)
        await asyncio.sleep(20.0)
        silent = faults.begin(PoweredOff(ATV))
        faults.end(cut_off)
        await asyncio.sleep(2.0 * BELIEVED_S)
        assert ATV not in factory.floor.lifted
        faults.end(silent)

    play(script)
