"""What agents beside a gateway have counted, told to Prometheus."""

from __future__ import annotations

import asyncio

from prometheus_client import CollectorRegistry

from dray.cli.meters import FactoryMeter
from dray.plant import default_plant
from dray_sim.bridge import BridgedBus
from dray_sim.factory import SimFactory
from dray_sim.loop import clock, run


def test_counts_go_on_when_an_agent_begins_another_life() -> None:
    told: list[float] = []

    async def play() -> None:
        loop = asyncio.get_running_loop()
        factory = SimFactory(default_plant(), clock(), seed=1)
        registry = CollectorRegistry()
        registry.register(FactoryMeter(factory, BridgedBus(factory.bus, loop, loop)))

        def handled() -> float:
            value = registry.get_sample_value("dray_agent_events_handled_total")
            assert value is not None
            return value

        life = asyncio.create_task(factory.run())
        for _ in range(3):
            await asyncio.sleep(30.0)
            told.append(handled())
            factory.restart("ATV1")
            told.append(handled())
        assert registry.get_sample_value("dray_bus_messages_delivered_total") == factory.bus.delivered
        dropped = registry.get_sample_value("dray_agent_messages_dropped_total", {"kind": "heartbeat"})
        assert dropped == 0
        life.cancel()
        await asyncio.gather(life, return_exceptions=True)

    run(play())
    assert told == sorted(told)
    assert told[0] > 100
    assert told[0] == told[1], "a new life has counted nothing yet, and the old one is not forgotten"
