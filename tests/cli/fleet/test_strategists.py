"""Two strategists as processes: when the one that holds an order is killed the other one goes on with it, and all of it arrives once."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest
from fleets import AGENTS, DELIVERED_S, PIECES, PLANT, START_S, Fleet, Witness

from dray.messages import StrategistHeartbeat
from dray.messages.fact import GoalContracted, OrderFulfilled, OrderTakenOver
from dray.messages.keys import strategists_of
from dray_sim.remote.pieces import count_pieces

PAIR = strategists_of(2)

AWAY_S = 20.0
"""Real seconds that the killed one is away: 200 s of the plant."""


@pytest.fixture
def pair(tmp_path: Path) -> Iterator[Fleet]:
    """A fleet with two strategists."""
    started = Fleet(tmp_path, "--strategists", "2")
    yield started
    if started.process.poll() is None:
        started.stop()


@pytest.mark.campaign
def test_the_order_of_a_killed_strategist_is_delivered_by_the_other_one_exactly_once(pair: Fleet) -> None:
    product = next(each for each in PLANT.ordered if PLANT.machines_for(each))

    async def story() -> None:
        witness = Witness(pair.registry)
        try:
            async with asyncio.timeout(START_S):
                await witness.all_there({*AGENTS, *PAIR})
            async with asyncio.timeout(DELIVERED_S):
                order = await asyncio.to_thread(pair.place, product, PIECES)
                holder = (await witness.told(GoalContracted)).agent
                await asyncio.to_thread(pair.run, "kill", holder, "--away", str(AWAY_S))
                next_one = await witness.told(OrderTakenOver)
                assert {holder, next_one.agent} == set(PAIR)
                assert (await witness.told(OrderFulfilled)).agent == next_one.agent
                while (seen := await asyncio.to_thread(pair.order, order))["status"] != "delivered":
                    await witness.until_more()
                assert [item["delivered"] for item in seen["items"]] == [PIECES]
                await witness.until(
                    lambda heard: (
                        isinstance(heard, StrategistHeartbeat)
                        and heard.strategist == holder
                        and heard.incarnation >= 2
                    )
                )
            pieces = await count_pieces(witness.bus.inner, PLANT.id)
            assert pieces.delivered == {product: PIECES}
        finally:
            witness.bus.close()

    asyncio.run(story())
    assert pair.stop() == 0
