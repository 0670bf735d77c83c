"""An agent that is shut out of a simulated factory: silent for everybody, replaced as any other that failed."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from random import Random
from typing import Any

import pytest

from dray.messages import AtvHeartbeat, MachineHeartbeat, Message, Role, ShutOut
from dray.messages.keys import Keys
from dray.messages.speakers import FOREIGN_WORD, SHUT_OUT
from dray.plant import default_plant
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

KEYS = Keys(default_plant().id)

BUSY_S = 300.0
"""By then vehicles carry something."""

PATIENCE_S = 1200.0
"""So long at most until one is found that is watched."""

TAKEN_OVER_S = 30.0
"""A silent primary is replaced within 3.5 s and a way of messages; this is ample."""


class Listener:
    """What is said, once the network has let it pass."""

    def __init__(self) -> None:
        self.last: dict[str, tuple[float, AtvHeartbeat | MachineHeartbeat]] = {}

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if isinstance(message, AtvHeartbeat | MachineHeartbeat):
            self.last[sender] = at_s, message


def in_a_busy_factory(story: Callable[[SimFactory, Listener], Coroutine[Any, Any, None]]) -> None:
    async def main() -> None:
        listener, plant = Listener(), default_plant()
        factory = SimFactory(plant, clock(), seed=1, listener=listener)
        orders = demand.orders(plant, Random(1), load=0.6, until_s=BUSY_S + PATIENCE_S)
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(OrderClient(factory.bus, clock()).place(orders)),
            ]
            await asyncio.sleep(BUSY_S)
            await story(factory, listener)
            for task in tasks:
                task.cancel()

    run(main())


async def next_carrier(listener: Listener) -> AtvHeartbeat:
    """The next vehicle that fetches something and is watched."""
    for _ in range(int(PATIENCE_S)):
        if found := carrier(listener):
            return found
        await asyncio.sleep(1.0)
    raise AssertionError("nobody carries anything")


def carrier(listener: Listener) -> AtvHeartbeat | None:
    """A vehicle that fetches something and is watched."""
    watched = {
        brief.task
        for _, beat in listener.last.values()
        if isinstance(beat, AtvHeartbeat)
        for brief in beat.watches
        if brief.role is Role.SECONDARY
    }
    for _, beat in listener.last.values():
        if isinstance(beat, AtvHeartbeat) and beat.task and not beat.load and beat.task.task in watched:
            return beat
    return None


def test_a_carrier_that_is_shut_out_is_replaced_and_takes_part_again_when_it_is_readmitted() -> None:
    async def story(factory: SimFactory, listener: Listener) -> None:
        gateway = factory.bus.join("gateway", lambda *_: None)
        out = await next_carrier(listener)
        assert out.task is not None
        gateway.publish(KEYS.shut_out, ShutOut(1, (out.atv,)))
        at_s = clock().now_s()
        await asyncio.sleep(TAKEN_OVER_S)
        assert listener.last[out.atv][0] <= at_s, "nobody hears it"
        assert factory.bus.refused[SHUT_OUT] > TAKEN_OVER_S / 5
        (machine,) = (beat for name, (_, beat) in listener.last.items() if name == out.task.coordinator)
        assert isinstance(machine, MachineHeartbeat)
        assert out.atv not in {task.primary for task in machine.tasks}
        gateway.publish(KEYS.shut_out, ShutOut(2))
        await asyncio.sleep(TAKEN_OVER_S)
        assert listener.last[out.atv][0] > at_s + TAKEN_OVER_S

    in_a_busy_factory(story)


@pytest.mark.parametrize("liar", ["ATV1", "M1", "strategist"])
def test_nobody_of_the_plant_shuts_anybody_out(liar: str) -> None:
    async def main() -> None:
        factory = SimFactory(default_plant(), clock(), seed=1)
        factory.bus.join(liar, lambda *_: None).publish(KEYS.shut_out, ShutOut(1, ("ATV2",)))
        assert factory.bus.shut_out == frozenset()
        assert factory.bus.refused == {FOREIGN_WORD: 1}

    run(main())


def test_an_older_decision_changes_nothing() -> None:
    async def main() -> None:
        factory = SimFactory(default_plant(), clock(), seed=1)
        gateway = factory.bus.join("gateway", lambda *_: None)
        for number, agents in ((2, ("ATV2",)), (1, ()), (2, ())):
            gateway.publish(KEYS.shut_out, ShutOut(number, agents))
        assert factory.bus.shut_out == {"ATV2"}

    run(main())
