"""The gate on a floor elsewhere, as the body of an agent that is a process."""

from __future__ import annotations

import asyncio

from floor_house import House, Listener, in_a_house

from dray.body import Admit, GateState, GoodsArrived
from dray.messages.keys import GATE
from dray_sim.clock.loop import clock


def test_what_came_in_while_the_agent_was_away_is_sensed_by_its_next_life() -> None:
    async def test(house: House) -> None:
        one = await house.take_over(GATE, 1)
        told = Listener(one)
        one.instruct(Admit("G1", 5))
        await told.until(GoodsArrived)
        # It is killed, and hears of none of this.
        assert house.floor.gate.enter("G1", 2) == ""
        # The gate reports at this instant, and so before this.
        reported = asyncio.Event()
        clock().call_at(clock().now_s(), reported.set)
        await reported.wait()
        again = await house.take_over(GATE, 2)
        assert again.sense() == GateState({"G1": 2})
        told = Listener(again)
        assert house.floor.gate.enter("G1", 3) == ""
        await told.until(GoodsArrived)
        assert told.reports == [GoodsArrived("G1", 5, 5)]
        assert house.floor.gate.enter("G1", 1) != ""

    in_a_house(test)
