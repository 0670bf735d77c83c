"""What agents beside a gateway have counted, told to Prometheus."""

from __future__ import annotations

import asyncio
from contextlib import closing
from pathlib import Path
from random import Random

from prometheus_client import CollectorRegistry

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.system_clock import SystemClock
from dray.cli.runtime.telemetry.agent_meter import AgentMeter
from dray.cli.runtime.telemetry.body_meter import BodyMeter
from dray.cli.runtime.telemetry.clock_meter import ClockMeter
from dray.cli.simulation.factory_meter import FactoryMeter
from dray.messages.keys import Keys
from dray.plant import default_plant
from dray.protocol.machine.machine import Machine
from dray.supervision import Failures
from dray.worker.worker import Worker
from dray_sim.bodies.floor import Floor
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.bridge import BridgedBus
from dray_sim.network.sim_network import SimNetwork


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


def test_an_agent_in_a_process_of_its_own_tells_what_it_has_handled_and_written(tmp_path: Path) -> None:
    plant = default_plant()
    registry = CollectorRegistry()

    def told(name: str, **labels: str) -> float | None:
        return registry.get_sample_value(f"dray_{name}", labels)

    async def play() -> None:
        floor, now = Floor(plant, clock(), seed=1), clock()
        with closing(SqliteJournal(tmp_path / "M1.db", events_kept=100)) as journal:
            worker = Worker(
                Machine("M1", plant, incarnation=journal.incarnation),
                bus=SimNetwork(now, Random(1)),
                clock=now,
                keys=Keys(plant.id),
                body=floor.bodies["M1"],
                journal=journal,
            )
            registry.register(AgentMeter(worker, journal))
            assert told("agent_events_handled_total") == told("journal_write_seconds_count") == 0
            life = asyncio.create_task(worker.run())
            await asyncio.sleep(10.0)
            floor.workcells["M1"].break_down("a belt has torn")
            await asyncio.sleep(10.0)
            worker.stop()
            await life

    run(play())
    handled, written = told("agent_events_handled_total"), told("journal_write_seconds_count")
    assert handled is not None
    assert written is not None
    assert handled > written > 0
    seconds = told("journal_write_seconds_sum")
    assert seconds is not None
    assert 0 < seconds / written < 60.0
    assert told("agent_events_waiting") == 0
    assert told("agent_messages_dropped_total", kind="other") == 0


def test_what_could_not_be_dealt_with_of_what_a_body_has_said_is_told_by_kind() -> None:
    link, body, registry = Failures("the link"), Failures("the body"), CollectorRegistry()
    registry.register(BodyMeter((link, body)))
    for failures, kind in ((link, "state"), (body, "state"), (body, "Woke")):
        try:
            {}[kind]
        except KeyError:
            failures.note(kind)
    told = {
        kind: registry.get_sample_value("dray_body_messages_failed_total", {"kind": kind})
        for kind in ("state", "Woke")
    }
    assert told == {"state": 2, "Woke": 1}


def test_a_clock_tells_how_often_it_was_set_and_what_it_has_to_make_up_for() -> None:
    offset_s, registry = 0.0, CollectorRegistry()

    async def play() -> None:
        nonlocal offset_s
        loop = asyncio.get_running_loop()
        registry.register(ClockMeter(SystemClock(loop, unix_s=lambda: loop.time() + offset_s)))
        assert told() == (0, 0)
        offset_s = 60.0
        assert told() == (1, 60)
        await asyncio.sleep(1.0)
        assert told() == (1, 59.9)

    def told() -> tuple[float | None, float | None]:
        steps = registry.get_sample_value("dray_clock_steps_total")
        behind_s = registry.get_sample_value("dray_clock_behind_seconds")
        return steps, None if behind_s is None else round(behind_s, 3)

    run(play())
