"""Benchmark `bus`: the cost of messages between agents, in process and on virtual time.

The work is that of a plant: vehicles publish heartbeats, machines listen to all of them. The baseline is the least
that a simulation needs: a heap of timed calls, and the calls. The further figures add the network (receivers, delay,
order), the codec, the trace, and the workers with their tasks.
"""

from __future__ import annotations

import asyncio
import heapq
from collections.abc import Callable
from itertools import count
from random import Random

from msgspec.structs import replace

from dray.codec import decode, encode
from dray.messages import AtvHeartbeat, AtvStatus, Brief, Message, Phase, Pose, Role
from dray.messages.keys import Keys
from dray.protocol.runtime.events import NEVER_S, Effect, Event, Publish, Subscribe, Woke
from dray.worker.worker import Worker
from dray_sim.bench.row import Row, rates
from dray_sim.clock.loop import clock, run
from dray_sim.factory.journal import HeldJournal
from dray_sim.network.sim_network import SimNetwork
from dray_sim.run.trace import Trace

VEHICLES = 50
"""The plant for which a simulation is to run at 500 times real time."""

MACHINES = 20
"""Every one hears every vehicle: more listeners than a real plant's heartbeats have."""

PERIOD_S = 0.1
"""Ten times as often as real heartbeats, so that the figure is about the bus and not about idling."""

SPAN_S = 30.0
"""Virtual time of one run: 300,000 deliveries, enough for a heap in its ordinary state."""

QUICK_SPAN_S = 3.0

TARGET_PER_S = 150_000
"""Deliveries per second that leave nine tenths of the time to the agents at 500 times real time."""

KEYS = Keys("bench")

HEARTBEAT = AtvHeartbeat(
    atv="ATV-07",
    incarnation=1,
    seq=1234,
    at_s=5678.9,
    status=AtvStatus.WORKING,
    pose=Pose(x_m=12.5, y_m=40.25, heading_rad=1.57),
    node="n17",
    speed_mps=1.4,
    battery_frac=0.62,
    task=Brief(task="M1-17", epoch=1, role=Role.PRIMARY, coordinator="M1", phase=Phase.CARRYING, quantity=8),
    way=("n18", "n19", "n20", "n21"),
    software="1.0.0",
)


def measure(quick: bool) -> list[Row]:
    """Measure the bus.

    Args:
        quick: a tenth of the work.
    """
    span_s = QUICK_SPAN_S if quick else SPAN_S
    calls = int(span_s * MACHINES * VEHICLES / PERIOD_S)
    return [
        _row("network", lambda: _deliveries(span_s), calls, TARGET_PER_S),
        _row("network and trace", lambda: _deliveries(span_s, trace=Trace()), calls),
        _row("network, trace and codec", lambda: _deliveries(span_s, trace=Trace(), codec=True), calls),
        _row("network and workers", lambda: _worker_events(span_s), calls),
        _codec_row(20_000 if quick else 200_000),
    ]


def _row(name: str, work: Callable[[], int], calls: int, target: float | None = None) -> Row:
    figure, baseline = rates(work, lambda: _bare_calls(calls))
    return Row(f"bus: deliveries, {name}", figure, "1/s", baseline, "bare heap of timed calls", target)


def _bare_calls(calls: int) -> int:
    """Keep as many pending calls as the network has on average; each call makes the next one."""
    heap: list[tuple[float, int, object, tuple[str, Message]]] = []
    numbers, random = count(), Random(1)
    heard = 0

    def on_message(_sender: str, _message: Message) -> None:
        nonlocal heard
        heard += 1

    for _ in range(VEHICLES * 4):
        heapq.heappush(heap, (random.random(), next(numbers), on_message, ("ATV-07", HEARTBEAT)))
    for _ in range(calls):
        when_s, _, _, args = heapq.heappop(heap)
        on_message(*args)
        heapq.heappush(heap, (when_s + random.random(), next(numbers), on_message, args))
    return heard


def _deliveries(span_s: float, *, trace: Trace | None = None, codec: bool = False) -> int:
    async def main() -> int:
        plant_clock = clock()
        network = SimNetwork(plant_clock, Random(1), codec=codec, trace=trace)

        def on_message(_sender: str, _message: Message) -> None:
            """The agent's own work is not measured here."""

        for number in range(MACHINES):
            network.join(f"M{number}", on_message).subscribe(KEYS.all_heartbeats)

        def beat(number: int) -> None:
            sessions[number].publish(KEYS.atv_heartbeat(f"ATV-{number}"), heartbeats[number])
            plant_clock.call_at(plant_clock.now_s() + PERIOD_S, beat, number)

        sessions = [network.join(f"ATV-{number}", on_message) for number in range(VEHICLES)]
        heartbeats = [replace(HEARTBEAT, atv=session.agent) for session in sessions]
        for number in range(VEHICLES):
            plant_clock.call_at(number * PERIOD_S / VEHICLES, beat, number)
        await asyncio.sleep(span_s)
        return network.delivered

    return run(main())


class _Mute:
    """An agent that listens to all heartbeats and does nothing with them."""

    incarnation = 1
    wake_at_s = NEVER_S

    def __init__(self, number: int) -> None:
        self.id = f"M{number}"
        self._effects: list[Effect] = [Subscribe(KEYS.all_heartbeats)]

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        effects, self._effects = self._effects, []
        return effects


class _Beating:
    """An agent that says its heartbeat and nothing else."""

    incarnation = 1

    def __init__(self, number: int) -> None:
        self.id = f"ATV-{number}"
        self.wake_at_s = number * PERIOD_S / VEHICLES
        self._key = KEYS.atv_heartbeat(self.id)
        self._said = replace(HEARTBEAT, atv=self.id)

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        if not isinstance(event, Woke):
            return []
        self.wake_at_s = now_s + PERIOD_S
        return [Publish(self._key, self._said)]


def _worker_events(span_s: float) -> int:
    async def main() -> int:
        plant_clock = clock()
        network = SimNetwork(plant_clock, Random(1))
        agents = [_Mute(number) for number in range(MACHINES)] + [_Beating(n) for n in range(VEHICLES)]
        workers = [
            Worker(agent, bus=network, clock=plant_clock, keys=KEYS, body=None, journal=HeldJournal())
            for agent in agents
        ]
        async with asyncio.TaskGroup() as group:
            for worker in workers:
                group.create_task(worker.run())
            await asyncio.sleep(span_s)
            for worker in workers:
                worker.stop()
        return sum(worker.handled for worker in workers)

    return run(main())


def _codec_row(messages: int) -> Row:
    def there_and_back() -> int:
        for _ in range(messages):
            decode(encode("ATV-07", HEARTBEAT))
        return messages

    def write() -> int:
        for _ in range(messages):
            encode("ATV-07", HEARTBEAT)
        return messages

    figure, baseline = rates(there_and_back, write)
    return Row("bus: heartbeats written and read", figure, "1/s", baseline, "writing alone")
