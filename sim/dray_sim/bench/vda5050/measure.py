"""CPU of a driver, and the time from a grant to the order on the wire, each beside a bare MQTT client."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager

import aiomqtt

from dray.adapters.system_clock import SystemClock
from dray.adapters.vda5050.body import HEARD, Address, VehicleBody
from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.events import Memory
from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.adapters.vda5050.profile import Profile, load_profile
from dray.body import ActionFailed, Drive, ReleaseWay, Report, WayDone
from dray.errors import UnavailableError
from dray.plant import Plant, load_plant
from dray.plant.model import VehicleSpec
from dray_sim.bench.row import Row
from dray_sim.bench.vda5050.vehicles import MANUFACTURER, PLANT, STATES_HZ, chosen
from dray_sim.run.observer import percentile
from dray_sim.vda5050.local_broker import local_broker

VEHICLES = 10
SPAN_S, QUICK_S = 20.0, 3.0
WAIT_S = 60.0
MOST_FRAC = 0.05
"""Most processor time of a driver, as a part of one processor: a vehicle's computer has other work."""

P99_S = 0.1
"""Longest time from a grant to the order on the wire: a vehicle at 1.5 m/s drives 15 cm meanwhile."""


def measure(quick: bool) -> list[Row]:
    """Ten drivers and ten vehicles on one broker of this computer."""
    return asyncio.run(_measure(QUICK_S if quick else SPAN_S))


async def _measure(span_s: float) -> list[Row]:
    plant, profile = load_plant(PLANT), load_profile("dray-sim")
    with local_broker() as broker, _vehicles(broker.port):
        bare = await _bare(broker, profile, plant, span_s)
        ours = await _drivers(broker, profile, plant, span_s)
    cpu, bare_cpu = ours.cpu_s / span_s / VEHICLES, bare.cpu_s / span_s / VEHICLES
    p99_s, bare_p99_s = percentile(ours.delays_s, 0.99), percentile(bare.delays_s, 0.99)
    hz = f"{ours.heard / span_s / VEHICLES:.1f} messages a second heard by each, {bare.heard / span_s / VEHICLES:.1f} by bare ones"
    return [
        Row(
            "vda5050: processor per driver",
            100.0 * cpu,
            "%",
            100.0 * bare_cpu,
            "bare MQTT client",
            target=100.0 * MOST_FRAC,
            note=f"{VEHICLES} vehicles, {STATES_HZ:g} states a second each; {hz}",
            less=True,
        ),
        Row(
            "vda5050: grant to order on the wire, p99",
            1000.0 * p99_s,
            "ms",
            1000.0 * bare_p99_s,
            "bare publish",
            target=1000.0 * P99_S,
            note=f"{len(ours.delays_s)} orders, median {1000.0 * percentile(ours.delays_s, 0.5):.1f} ms; {ours.failed} ways failed",
            less=True,
        ),
    ]


class _Count:
    """The measurements of one run."""

    def __init__(self) -> None:
        self.cpu_s = 0.0
        self.heard = 0
        self.failed = 0
        self.delays_s: list[float] = []


@contextmanager
def _vehicles(port: int) -> Iterator[None]:
    main = "from dray_sim.bench.vda5050.vehicles import main; main()"
    command = [sys.executable, "-c", main, str(port), str(VEHICLES)]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as process:  # noqa: S603
        try:
            yield
        finally:
            if process.stdin is not None:
                process.stdin.close()
            process.wait(WAIT_S)


@asynccontextmanager
async def _probe(broker: BrokerAddress, topic: str) -> AsyncIterator[dict[str, asyncio.Future[float]]]:
    """Tells when the next message on each topic that it waits for has come."""
    waits: dict[str, asyncio.Future[float]] = {}

    async def listen(client: aiomqtt.Client) -> None:
        async for message in client.messages:
            waiting = waits.pop(message.topic.value, None)
            if waiting is not None and not waiting.done():
                waiting.set_result(time.perf_counter())

    async with aiomqtt.Client(broker.host, broker.port, identifier="probe") as client:
        await client.subscribe(topic)
        task = asyncio.create_task(listen(client))
        try:
            yield waits
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)


async def _bare(broker: BrokerAddress, profile: Profile, plant: Plant, span_s: float) -> _Count:
    """Clients that hear the same, and publish as much as an order, at about the same rate."""
    count = _Count()
    prefixes = [profile.topic(MANUFACTURER, spec.id, "").rstrip("/") for spec in chosen(plant, VEHICLES)]

    async def client_of(prefix: str, waits: dict[str, asyncio.Future[float]]) -> None:
        async with aiomqtt.Client(
            broker.host, broker.port, identifier=f"bare-{prefix.replace('/', '-')}"
        ) as client:
            for topic in HEARD:
                await client.subscribe(f"{prefix}/{topic}")
            said_s = time.perf_counter()
            async for _ in client.messages:
                count.heard += 1
                if time.perf_counter() - said_s > 1.0:
                    said_s, topic = time.perf_counter(), f"{prefix}/bare"
                    waits[topic] = asyncio.get_running_loop().create_future()
                    await client.publish(topic, b"x" * 800)
                    count.delays_s.append(await waits[topic] - said_s)

    async with _probe(broker, "+/+/+/+/bare") as waits:
        tasks = [asyncio.create_task(client_of(prefix, waits)) for prefix in prefixes]
        await asyncio.sleep(2.0)
        count.heard, begun_s = 0, time.process_time()
        await asyncio.sleep(span_s)
        count.cpu_s = time.process_time() - begun_s
        await _end(tasks)
    return count


class _World:
    """The world of one driver, without its disk writes, which are the same for every driver."""

    def __init__(self, link: MqttLink) -> None:
        self._link = link

    def publish(self, topic: str, data: bytes) -> None:
        self._link.publish(topic, data)

    def remember(self, memory: Memory) -> None:
        """Not measured."""

    def note(self, text: str) -> None:
        """Not measured."""


async def _drivers(broker: BrokerAddress, profile: Profile, plant: Plant, span_s: float) -> _Count:
    count = _Count()
    clock = SystemClock(asyncio.get_running_loop())
    links, bodies = [], []
    for spec in chosen(plant, VEHICLES):
        control = MasterControl(
            spec.id, plant, plant.vehicle_types[spec.type], profile, life=int(time.time())
        )
        link = MqttLink(
            broker, profile.topic(MANUFACTURER, spec.id, "").rstrip("/"), f"dray-{spec.id}", HEARD
        )
        body = VehicleBody(control, profile, Address(MANUFACTURER, spec.id), clock, _World(link), lambda s: s)
        body.record = lambda _now_s, event, *_: _note(count, event)
        bodies.append((spec, body))
        links.append(asyncio.create_task(link.run(body)))
    try:
        await _until_known([body for _, body in bodies])
        async with _probe(broker, f"{profile.dialect.prefix}/{MANUFACTURER}/+/order") as waits:
            tasks = [
                asyncio.create_task(_to_and_fro(spec, body, plant, profile, waits, count))
                for spec, body in bodies
            ]
            await asyncio.sleep(2.0)
            count.heard, begun_s = 0, time.process_time()
            await asyncio.sleep(span_s)
            count.cpu_s = time.process_time() - begun_s
            await _end(tasks)
    finally:
        await _end(links)
    return count


async def _end(tasks: list[asyncio.Task[None]]) -> None:
    """Cancel them; one that has failed before says so."""
    for task in tasks:
        task.cancel()
    for result in await asyncio.gather(*tasks, return_exceptions=True):
        if isinstance(result, Exception):
            raise result


def _note(count: _Count, event: object) -> None:
    count.heard += type(event).__name__ == "Heard"


async def _until_known(bodies: list[VehicleBody]) -> None:
    try:
        async with asyncio.timeout(WAIT_S):
            # The bodies have no common event to wait for.
            while not all(body.control.is_known for body in bodies):  # noqa: ASYNC110
                await asyncio.sleep(0.1)
    except TimeoutError:
        why = next(body.control.why_unknown for body in bodies if not body.control.is_known)
        raise UnavailableError(
            "a simulated vehicle", why, "is the computer busy with something else?"
        ) from None


async def _to_and_fro(
    spec: VehicleSpec,
    body: VehicleBody,
    plant: Plant,
    profile: Profile,
    waits: dict[str, asyncio.Future[float]],
    count: _Count,
) -> None:
    """Drive one lane after the other; grant each after its way was given."""
    loop, order = asyncio.get_running_loop(), 0
    over: asyncio.Future[Report] = loop.create_future()

    def on_report(report: Report) -> None:
        if isinstance(report, WayDone | ActionFailed) and report.order == order and not over.done():
            over.set_result(report)

    body.attach(on_report)
    topic = profile.topic(MANUFACTURER, spec.id, "order")
    while True:
        order += 1
        over = loop.create_future()
        here = body.control.sense().next_node
        lane = plant.roads.leaving[here][0]
        body.instruct(Drive(order=order, nodes=(here, lane.end), released=1))
        # A real grant, too, comes some time after the vehicle stands and its state is known.
        await asyncio.sleep(0.3)
        waits[topic] = loop.create_future()
        granted_s = time.perf_counter()
        body.instruct(ReleaseWay(order=order, released=2))
        count.delays_s.append(await waits[topic] - granted_s)
        if isinstance(await over, ActionFailed):
            count.failed += 1
