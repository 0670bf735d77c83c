"""A storage that fills itself leaves room for a load on its way: the load is brought at once, by the first vehicle."""

from __future__ import annotations

import asyncio
from math import inf

from dray.messages import Event, Message, TransportOrdered, TransportState
from dray.messages.fact import TaskClosed
from dray.plant.file.file import shipped_plant
from dray_sim.bodies.stores import REFILL_S
from dray_sim.people.transport_caller import Call, TransportCaller
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play

ITEM, FROM, TO = "shaft", "S3", "S1"
WITHIN_S = 900.0


class Closed:
    """Outcomes of transports, in their order."""

    def __init__(self) -> None:
        self.outcomes: list[str] = []

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is Event and type(message.fact) is TaskClosed:
            self.outcomes.append(message.fact.outcome)


async def _called_while_it_fills_itself(stage: Stage) -> tuple[list[str], int]:
    """Let people take more than half of it back to the warehouse, and call for a load that comes later than the refill."""
    closed, storage = Closed(), stage.factory.storages[TO]
    stage.listeners.add(closed)
    lot = stage.plant.materials[ITEM].lot
    await stage.until_s(60.0)
    taken = storage.stock[ITEM] // 2 + lot
    storage.take("", ITEM, taken)
    stage.factory.source.put("", ITEM, taken)
    await stage.until_s(60.0 + 0.8 * REFILL_S)
    caller = TransportCaller(stage.factory.bus, stage.factory.clock)
    order = TransportOrdered("T-1", FROM, ITEM, lot, stage.now_s() + WITHIN_S)
    calling = asyncio.create_task(caller.call([Call(stage.now_s(), TO, order, inf)]))
    await asyncio.wait([calling], timeout=WITHIN_S)
    calling.cancel()
    assert caller.states["T-1"] is TransportState.DELIVERED
    return closed.outcomes, storage.stock[ITEM]


def test_a_load_is_brought_at_once_to_a_storage_that_fills_itself_meanwhile() -> None:
    plant = shipped_plant("single-track")
    run = play(Shift(name="calls", duration_s=3600.0), plant, 1, _called_while_it_fills_itself)
    assert run.invariants == HELD
    assert run.result is not None
    outcomes, stock = run.result
    assert outcomes == ["delivered"]
    assert stock == next(kept.capacity for kept in plant.storages[TO].stocks if kept.material == ITEM)
