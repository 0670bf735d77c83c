"""The gate as a process: killed while an order is in work, it has missed nothing and counts nothing twice when it is back."""

from __future__ import annotations

import asyncio
from collections import Counter

import pytest
from fleets import AGENTS, DELIVERED_S, PIECES, PLANT, START_S, Fleet, Witness

from dray.messages import Event, StationHeartbeat
from dray.messages.fact import GoalContracted, GoodsDelivered, OrderFulfilled
from dray.messages.keys import GATE
from dray_sim.remote.pieces import count_pieces

AWAY_S = 60.0
"""Real seconds: 600 s of the plant, in which all of the order is made and brought."""


@pytest.mark.campaign
def test_what_comes_in_while_the_gate_is_killed_is_told_once_when_it_is_back(fleet: Fleet) -> None:
    product = next(each for each in PLANT.ordered if PLANT.machines_for(each))

    async def story() -> None:
        witness = Witness(fleet.registry)
        try:
            async with asyncio.timeout(START_S):
                await witness.all_there(AGENTS)
            async with asyncio.timeout(DELIVERED_S):
                order = await asyncio.to_thread(fleet.place, product, PIECES)
                await witness.told(GoalContracted)
                await asyncio.to_thread(fleet.run, "kill", GATE, "--away", str(AWAY_S))
                # All of it is in, and nobody has said so.
                while (await count_pieces(witness.bus.inner, PLANT.id)).delivered != {product: PIECES}:
                    await witness.until_more()
                assert not any(
                    isinstance(each, Event) and isinstance(each.fact, OrderFulfilled)
                    for each in witness.heard
                )
                await witness.told(OrderFulfilled)
                assert any(
                    isinstance(each, StationHeartbeat) and each.station == GATE and each.incarnation >= 2
                    for each in witness.heard
                )
                while (seen := await asyncio.to_thread(fleet.order, order))["status"] != "delivered":
                    await witness.until_more()
                assert [item["delivered"] for item in seen["items"]] == [PIECES]
            counted: Counter[str] = Counter()
            for each in witness.heard:
                if isinstance(each, Event) and isinstance(each.fact, GoodsDelivered):
                    counted[each.fact.product] += each.fact.quantity
            assert counted == {product: PIECES}
        finally:
            witness.bus.close()

    asyncio.run(story())
    assert fleet.stop() == 0
