"""Benchmark `fleet`: the cost of a factory whose agents are processes, by its number of vehicles.

`dray fleet up` runs in real time, with certificates and with orders for all machines. Its processes are measured from
outside: processor time and memory by the kernel, messages by a listener on the bus. The baseline is the same with as
many vehicles as the default plant has.

Every message of an agent counts once, however many hear it. Messages between the simulated floor and an agent do not
count, for they stand for a vehicle's own wires. The floor reports each body's state to its agent ten times a second;
the agents' processor time includes that.
"""

from __future__ import annotations

import asyncio
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import zenoh
from zenoh.handlers import Callback

from dray.adapters.zenoh.bus import ZenohBus
from dray.cli.fleet.folder import GATEWAY
from dray.cli.fleet.process_registry import Member
from dray.cli.runtime.roster import FLOOR
from dray.errors import UnavailableError
from dray.messages import OrderItem
from dray.messages.kinds import Kind
from dray.plant import Plant
from dray_sim.bench.losses.customer import Customer
from dray_sim.bench.losses.fleet import Fleet, running
from dray_sim.bench.losses.watch import gathered
from dray_sim.bench.row import Row
from dray_sim.bench.usage import Usage
from dray_sim.people.demand import Order
from dray_sim.plants.generator import generate_plant

SEED = 1


@dataclass(frozen=True, slots=True)
class Size:
    """Size and duration of one measurement.

    Attributes:
        machines, vehicles: of the factory.
        warm_s: until machines have found goals, and vehicles tasks.
        span_s: for which it is measured.
    """

    machines: int
    vehicles: int
    warm_s: float
    span_s: float


SIZES = Size(20, 50, 60.0, 60.0), Size(12, 8, 60.0, 60.0)
"""The large factory, and one as large as the default plant."""

QUICK_SIZES = Size(3, 4, 20.0, 20.0), Size(2, 2, 20.0, 20.0)

JOIN_S = 600.0
"""Longest time for all processes to import and join, on a busy computer."""

LEASE_S = 30.0
"""Longer than the usual lease, because dozens of processes that start on one computer wait for the processor. A
shorter lease would cut links, and making them anew is still more work."""

PIECES = 60
"""Ordered pieces of each product, for each machine that makes it: half an hour's work."""

DUE_S = 86_400.0
"""A day: the orders only keep machines busy."""

SAID = {"hb": "heartbeats", "event": "facts", "agent": "to one agent", "task": "announcements"}
"""Kinds of messages by the second chunk of their key; the rest are goals and dwell points."""


@dataclass(frozen=True, slots=True)
class Observed:
    """A factory, while it was measured.

    Attributes:
        joined_s: until all were on the bus.
        said: messages a second, by kind.
        kinds: usage per second of one process of each kind.
        processes: how many there are.
        processor_s: processor time per second of all processes.
        memory_mb: likewise.
    """

    joined_s: float
    said: dict[str, float]
    kinds: dict[str, Usage]
    processes: int
    processor_s: float
    memory_mb: float


class Listener:
    """Counts the messages on a bus, by kind.

    Attributes:
        heard: so far.
    """

    def __init__(self, bus: ZenohBus, agents: frozenset[str]) -> None:
        self.heard: Counter[str] = Counter()
        self._bus = bus
        # No wildcard matches a message to one agent.
        for key in (f"{bus.keys.plant}/**", *map(bus.keys.addressed, agents)):
            bus.inner.declare_subscriber(key, Callback(self._on_sample, indirect=False))

    def _on_sample(self, sample: zenoh.Sample) -> None:
        """Runs on a thread of Zenoh's."""
        kind = str(sample.key_expr).split("/")[1]
        with self._bus.lock:
            self.heard[SAID.get(kind, "other")] += 1


def measure(quick: bool, traffic: bool | None = None) -> list[Row]:
    """Measure a large factory and one of the usual size.

    Args:
        quick: far smaller ones, and for a shorter time.
        traffic: whether vehicles drive with right of way; None: as `dray fleet up` does.

    Raises:
        UnavailableError: a fleet does not start, or one of its processes ends meanwhile.
    """
    sizes = QUICK_SIZES if quick else SIZES
    large, usual = (asyncio.run(_observe(size, traffic)) for size in sizes)
    return list(_rows(large, usual, *sizes))


async def _observe(size: Size, traffic: bool | None) -> Observed:
    plant = generate_plant(SEED, size.machines, size.vehicles)
    with tempfile.TemporaryDirectory() as folder:
        began_s = time.monotonic()
        async with running(
            Path(folder), plant, speed=1.0, plain=False, lease_s=LEASE_S, traffic=traffic
        ) as fleet:
            with fleet.bus() as bus:
                await gathered(fleet, bus, JOIN_S)
                joined_s = time.monotonic() - began_s
                await _order(fleet, plant)
                await asyncio.sleep(size.warm_s)
                members = fleet.registry.members
                before, began_s = _used(members), time.monotonic()
                listener = Listener(bus, frozenset(member.name for member in members if member.joins))
                await asyncio.sleep(size.span_s)
                _refuse_new_lives(members, fleet.registry.members)
                said, span_s = Counter(listener.heard), time.monotonic() - began_s
                after = _used(members)
    counts = Counter(member.kind for member in members)
    return Observed(
        joined_s=joined_s,
        said={kind: count / span_s for kind, count in said.items()},
        kinds={
            kind: Usage(
                (after[kind].processor_s - before[kind].processor_s) / span_s / count,
                after[kind].memory_mb / count,
            )
            for kind, count in counts.items()
        },
        processes=len(members),
        processor_s=sum(after[kind].processor_s - before[kind].processor_s for kind in counts) / span_s,
        memory_mb=sum(after[kind].memory_mb for kind in counts),
    )


async def _order(fleet: Fleet, plant: Plant) -> None:
    """Order enough of everything that no machine is idle."""
    items = {product: PIECES * len(plant.machines_for(product)) for product in plant.products}
    orders = [
        Order(f"B-{product}", 0.0, DUE_S, (OrderItem(product, quantity),))
        for product, quantity in items.items()
        if quantity
    ]
    customer = Customer(fleet.url, fleet.token, fleet.time)
    await customer.place(orders, fleet.time.to_plant_s(time.time()))
    if customer.refused:
        why = next(iter(customer.refused.values()))
        raise UnavailableError("the fleet", f"refuses an order: {why}", fleet.last_words(GATEWAY))


def _refuse_new_lives(before: Iterable[Member], after: Iterable[Member]) -> None:
    """Check that no process has restarted: a restarted process has other work than one that takes part.

    Raises:
        UnavailableError: one has restarted.
    """
    starts = {member.name: member.starts for member in before}
    anew = [member.name for member in after if member.starts != starts[member.name]]
    if anew:
        remedy = "measure on a computer that has nothing else to do"
        raise UnavailableError(", ".join(anew), "ended while it was measured and was started again", remedy)


def _used(members: Iterable[Member]) -> dict[str, Usage]:
    """Total usage of the processes of each kind."""
    kinds: dict[str, list[int]] = {}
    for member in members:
        kinds.setdefault(member.kind, []).append(member.pid)
    return {kind: Usage.of(pids) for kind, pids in kinds.items()}


def _rows(large: Observed, usual: Observed, size: Size, usual_size: Size) -> Iterator[Row]:
    """The large factory beside the usual one."""
    name = f"fleet of {size.vehicles} vehicles"
    against = f"{usual_size.vehicles} vehicles and {usual_size.machines} machines"

    def row(what: str, figure: float, unit: str, baseline: float, note: str = "") -> Row:
        return Row(f"{name}: {what}", figure, unit, baseline, against, note=note, less=unit != "1/s")

    said = sorted(large.said.items(), key=lambda each: -each[1])
    yield row(
        "messages said",
        sum(large.said.values()),
        "1/s",
        sum(usual.said.values()),
        "; ".join(f"{kind} {rate:.1f}" for kind, rate in said),
    )
    for kind in (
        Kind.ATV,
        Kind.MACHINE,
        Kind.STATION,
        Kind.GATE,
        Kind.STRATEGIST,
        Kind.GATEWAY,
        Kind.HISTORIAN,
        FLOOR,
    ):
        mine, theirs = large.kinds[kind], usual.kinds[kind]
        note = f"{mine.memory_mb:.0f} MB, at {usual_size.vehicles} vehicles {theirs.memory_mb:.0f} MB"
        yield row(f"processor, {kind}", 1e3 * mine.processor_s, "ms/s", 1e3 * theirs.processor_s, note)
    yield row(
        f"processor, all {large.processes} processes",
        1e3 * large.processor_s,
        "ms/s",
        1e3 * usual.processor_s,
    )
    yield row(f"memory, all {large.processes} processes", large.memory_mb, "MB", usual.memory_mb)
    yield row("until all are on the bus", large.joined_s, "s", usual.joined_s)
