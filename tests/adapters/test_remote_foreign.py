"""Vehicles with bodies of their own at the places of a floor elsewhere: their words are counted once, and nobody else's are."""

from __future__ import annotations

import asyncio

import pytest
from floor_house import ATV, PLANT, House, in_a_house

from dray.adapters.remote_body import CountedBody, tell_moved
from dray.body import (
    ActionDone,
    ActionFailed,
    Drop,
    Instruction,
    OpenDock,
    Pick,
    ProblemCleared,
    Report,
    VehicleState,
)
from dray.errors import UnavailableError
from dray_sim.clock.loop import JUMP, run

STATION = next(iter(PLANT.storages))
ITEM = PLANT.storages[STATION].stocks[0].material
MACHINE = next(machine for machine in PLANT.machines if ITEM in PLANT.materials_of(machine))


def lies(house: House) -> dict[str, int]:
    return house.floor.count().balance


def test_what_a_foreign_vehicle_has_picked_and_dropped_is_counted_at_both_places_once() -> None:
    async def test(house: House) -> None:
        storage, machine, before = house.floor.storages[STATION], house.floor.workcells[MACHINE], lies(house)
        stock, level = storage.stock[ITEM], machine.sense().stock[ITEM]
        storage.instruct(OpenDock(ATV, ITEM, 2))
        pick, drop = Pick(order=1, station=STATION, item=ITEM, quantity=2), Drop(order=2, station=MACHINE)
        for _ in range(2):
            assert await tell_moved(house.here, PLANT.id, ATV, 1, pick) == ""
        assert storage.stock[ITEM] == stock - 2
        machine.instruct(OpenDock(ATV, ITEM, 2))
        for _ in range(2):
            assert await tell_moved(house.here, PLANT.id, ATV, 1, drop) == ""
        assert machine.sense().stock[ITEM] == level + 2
        assert lies(house) == before

    in_a_house(test, foreign=[ATV])


def test_what_no_dock_is_open_for_is_not_counted_and_no_piece_is_lost() -> None:
    async def test(house: House) -> None:
        before = lies(house)
        pick, drop = Pick(order=1, station=STATION, item=ITEM, quantity=2), Drop(order=2, station=MACHINE)
        assert await tell_moved(house.here, PLANT.id, ATV, 1, pick) == "the dock is shut"
        assert await tell_moved(house.here, PLANT.id, ATV, 1, drop) == "nothing on board"
        house.floor.storages[STATION].instruct(OpenDock(ATV, ITEM, 2))
        assert await tell_moved(house.here, PLANT.id, ATV, 2, pick) == ""
        assert await tell_moved(house.here, PLANT.id, ATV, 2, drop) == "the dock is shut"
        assert house.floor.in_hands[ITEM] == 2
        assert lies(house) == before

    in_a_house(test, foreign=[ATV])


def test_of_a_vehicle_that_is_simulated_there_no_word_is_believed() -> None:
    async def test(house: House) -> None:
        machine = house.floor.workcells[MACHINE]
        level = machine.sense().stock[ITEM]
        machine.instruct(OpenDock(ATV, ITEM, 2))
        with pytest.raises(UnavailableError, match="DRAY_FOREIGN"):
            await tell_moved(house.here, PLANT.id, ATV, 1)
        with pytest.raises(UnavailableError, match=f"{ATV} is simulated here"):
            await tell_moved(house.here, PLANT.id, ATV, 1, Drop(order=1, station=MACHINE))
        assert machine.sense().stock[ITEM] == level

    in_a_house(test)


def test_the_double_of_a_foreign_vehicle_is_off_the_floor_and_no_agent_has_it() -> None:
    async def test(house: House) -> None:
        assert ATV not in house.floor.standing
        with pytest.raises(UnavailableError, match="has a body of its own"):
            await house.take_over(ATV, 1)

    in_a_house(test, foreign=[ATV])


# --- the agent's side ----------------------------------------------------------------------------


class Vehicle:
    """A body whose reports a test makes."""

    def __init__(self) -> None:
        self.say = lambda _report: None

    def instruct(self, _instruction: Instruction) -> None:
        pass

    def sense(self) -> VehicleState:
        raise AssertionError

    def attach(self, report) -> None:  # type: ignore[no-untyped-def]
        self.say = report


def test_a_transfer_is_counted_before_it_is_reported_and_reports_keep_their_order() -> None:
    async def test() -> None:
        vehicle, heard, may_count = Vehicle(), [], asyncio.Event()

        async def tell(done: Pick | Drop) -> str:
            heard.append(done)
            await may_count.wait()
            return "the dock is shut"

        body = CountedBody(ATV, vehicle, tell)
        reports: list[Report] = []
        body.attach(reports.append)
        running = asyncio.create_task(body.run())
        pick = Pick(order=1, station=STATION, item=ITEM, quantity=2)
        body.instruct(pick)
        vehicle.say(ActionDone(order=1))
        vehicle.say(ProblemCleared())
        await asyncio.sleep(1.0)
        assert (heard, reports) == ([pick], [])
        may_count.set()
        await asyncio.sleep(1.0)
        assert reports == [ActionDone(order=1), ProblemCleared()]
        body.instruct(Drop(order=2, station=MACHINE))
        vehicle.say(ActionFailed(order=2, reason="the fork is jammed"))
        await asyncio.sleep(1.0)
        assert heard == [pick]
        running.cancel()

    run(test(), JUMP)
