"""What the benchmark of a factory of processes counts: processor time, memory, messages by kind."""

from __future__ import annotations

import asyncio
import os
import time

from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.messages import OrderTaken
from dray.messages.kinds import Kind
from dray_sim.bench.fleet import FLOOR, Listener, Observed, Size, _rows
from dray_sim.bench.network.bus import HEARTBEAT
from dray_sim.bench.usage import Usage

BUSY_S = 0.2


def test_a_process_is_charged_its_processor_time_and_its_memory() -> None:
    before = Usage.of([os.getpid()])
    end_s = time.process_time() + BUSY_S
    block = bytearray(50 * 2**20)
    while time.process_time() < end_s:
        block[-1] += 1
        block[-1] = 0
    after = Usage.of([os.getpid()])
    assert after.processor_s - before.processor_s >= BUSY_S / 2
    assert after.memory_mb > 1.0
    twice = Usage.of([os.getpid(), os.getpid()])
    assert twice.processor_s >= 2 * after.processor_s


def test_every_message_is_counted_once_by_its_kind() -> None:
    async def main() -> dict[str, int]:
        bus = ZenohBus(Links(plain=True), "p")
        try:
            listener = Listener(bus, frozenset({"A", "B"}))
            session = bus.join("ATV-07", lambda *_: None)
            session.publish(bus.keys.atv_heartbeat("ATV-07"), HEARTBEAT)
            session.publish(bus.keys.transports("1-1"), HEARTBEAT)
            session.publish(bus.keys.dwell_point("C1"), HEARTBEAT)
            for to in ("A", "A", "B", "nobody"):
                session.send(to, OrderTaken(order="1"))
            return dict(listener.heard)
        finally:
            bus.close()

    assert asyncio.run(main()) == {"heartbeats": 1, "announcements": 1, "to one agent": 3, "other": 1}


def observed(times: float) -> Observed:
    kinds = (
        *(Kind.ATV, Kind.MACHINE, Kind.STATION, Kind.GATE, Kind.STRATEGIST),
        Kind.GATEWAY,
        Kind.HISTORIAN,
        FLOOR,
    )
    return Observed(
        joined_s=times,
        said={"facts": times, "heartbeats": 2 * times},
        kinds={kind: Usage(times / 1000, 40.0) for kind in kinds},
        processes=6,
        processor_s=times,
        memory_mb=240.0 * times,
    )


def test_a_large_factory_stands_beside_a_small_one() -> None:
    rows = list(_rows(observed(3.0), observed(1.0), Size(2, 4, 1.0, 1.0), Size(1, 2, 1.0, 1.0)))
    assert {row.baseline_name for row in rows} == {"2 vehicles and 1 machines"}
    assert all(row.ratio == 3.0 for row in rows)
    said = rows[0]
    assert (said.figure, said.unit, said.note) == (9.0, "1/s", "heartbeats 6.0; facts 3.0")
