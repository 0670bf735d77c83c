"""Bodies on a floor elsewhere: agents use them as their own, whatever is lost on the way."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from random import Random
from typing import Any

import pytest
import zenoh
from floor_house import ATV, PLANT, House, Leaky, Listener, in_a_house, way_of
from msgspec.structs import replace

from dray.adapters.crossing import Crossing
from dray.adapters.remote_body import put_down, questions
from dray.body import (
    Admit,
    Broken,
    Drive,
    NodePassed,
    ReleaseWay,
    VehicleState,
    WayDone,
    WorkcellState,
)
from dray.errors import UnavailableError
from dray_sim.bodies.floor import Floor
from dray_sim.clock.loop import clock
from dray_sim.remote import FloorServer, count_pieces


def test_an_agent_senses_a_body_that_is_elsewhere() -> None:
    async def test(house: House) -> None:
        for agent, there in house.floor.bodies.items():
            body = await house.take_over(agent, 1)
            assert type(body.sense()) is type(there.sense())
        machine = next(iter(PLANT.machines))
        body = await house.take_over(machine, 2)
        assert body.sense() == house.floor.workcells[machine].sense()

    in_a_house(test)


def test_what_happens_there_is_reported_here_with_the_state_after_it() -> None:
    async def test(house: House) -> None:
        machine = next(iter(PLANT.machines))
        body = await house.take_over(machine, 1)
        listener = Listener(body)
        house.floor.workcells[machine].break_down("a belt has torn")
        await listener.until(Broken)
        state = body.sense()
        assert isinstance(state, WorkcellState)
        assert state.broken == "a belt has torn"

    in_a_house(test)


def test_a_vehicle_drives_there_as_it_is_told_here() -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        body = await house.take_over(ATV, 1)
        listener = Listener(body)
        body.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert [report.node for report in listener.reports if isinstance(report, NodePassed)] == list(nodes)
        state = body.sense()
        assert isinstance(state, VehicleState)
        assert state.node == nodes[-1]

    in_a_house(test)


def test_instructions_and_reports_arrive_once_and_in_order_also_when_most_messages_are_lost() -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        house.serving.cancel()
        floor = Floor(PLANT, clock(), seed=1)
        server: Any = Leaky(house.there, 1)
        telling = asyncio.create_task(FloorServer(server, PLANT.id, floor).run())
        body = await house.take_over(ATV, 5, Leaky(house.here, 2))
        listener = Listener(body)
        body.instruct(Drive(order=1, nodes=nodes, released=1))
        for released in range(2, len(nodes) + 1):
            body.instruct(ReleaseWay(order=1, released=released))
        await listener.until(WayDone)
        assert [report.node for report in listener.reports if isinstance(report, NodePassed)] == list(nodes)
        telling.cancel()

    in_a_house(test)


def test_letters_that_find_no_room_are_said_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        body = await house.take_over(ATV, 1)
        listener = Listener(body)
        # By chance: every fourth one might for ever be the same side's.
        offer, chance, refused = Crossing.offer, Random(1), 0

        def offer_one_in_four(self: Crossing, call: Callable[..., object], *args: Any) -> bool:
            nonlocal refused
            if chance.random() < 0.25:
                return offer(self, call, *args)
            refused += 1
            return False

        monkeypatch.setattr(Crossing, "offer", offer_one_in_four)
        body.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert refused
        assert [report.node for report in listener.reports if isinstance(report, NodePassed)] == list(nodes)

    in_a_house(test)


def test_a_joining_agent_that_does_not_fit_is_refused_with_the_reason() -> None:
    async def test(house: House) -> None:
        with pytest.raises(UnavailableError, match="has no type 'submarine'"):
            await put_down(house.here, PLANT.id, replace(PLANT.fleet[ATV], id="ATV99", type="submarine"))
        with pytest.raises(UnavailableError, match="has no node 'moon'"):
            await put_down(house.here, PLANT.id, replace(PLANT.fleet[ATV], id="ATV99", node="moon"))

    in_a_house(test)


def test_a_question_that_is_lost_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(house: House) -> None:
        lost: list[zenoh.Query] = []
        keep = zenoh.handlers.Callback(lost.append, indirect=False)

        class Forgetful(Leaky):
            """Its first question goes to somebody who never answers."""

            def get(self, key: str, *args: Any, **options: Any) -> None:
                self._session.get(key if lost else "nobody/answers", *args, **options)

        house.there.declare_queryable("nobody/answers", keep)
        await house.settle()
        body = await house.take_over(ATV, 1, Forgetful(house.here, 1))
        assert len(lost) == 1
        assert body.is_new

    monkeypatch.setattr(questions, "ANSWER_S", 0.2)
    in_a_house(test)


def test_a_joining_agent_is_put_down_once_and_drives() -> None:
    spec = replace(PLANT.fleet[ATV], id="ATV99")

    async def test(house: House) -> None:
        for _ in range(2):
            await put_down(house.here, PLANT.id, spec)
        assert len(house.floor.vehicles) == len(PLANT.fleet) + 1
        nodes = way_of(ATV)
        body = await house.take_over("ATV99", 1)
        listener = Listener(body)
        body.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert house.floor.vehicles["ATV99"].sense().node == nodes[-1]

    in_a_house(test)


def test_the_pieces_of_a_floor_are_counted_from_elsewhere() -> None:
    async def test(house: House) -> None:
        there = house.floor
        assert await count_pieces(house.here, PLANT.id) == there.count()
        there.gate.instruct(Admit(goal="G1", quantity=5))
        warehouse, product = next(iter(there.delivery.values())), next(iter(PLANT.products))
        assert warehouse.put(ATV, product, 5, "G1") == ""
        pieces = await count_pieces(house.here, PLANT.id)
        assert (pieces.arrived, pieces.delivered) == ({"G1": 5}, {product: 5})

    in_a_house(test)
