"""A probe: one more computer on a bus, which places an order and writes down what it hears.

It runs as a process of its own, in the network that it observes:

    python -m dray_sim.bench.network.probe '{"plant": ...}'       a `ProbeSpec`

and writes every message to its standard output, a line each, with the moment at which it came.
"""

from __future__ import annotations

import asyncio
import sys
import time
from pathlib import Path

import msgspec

from dray.adapters.security.identity import Identity
from dray.adapters.system_clock import SystemClock
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.codec import decode, encode
from dray.messages import Message, OrderItem
from dray.messages.keys import STRATEGIST, Keys
from dray_sim.people.demand import Order
from dray_sim.people.order_client import ORDER_CLIENT, OrderClient

AGAIN_S = 0.1
"""Interval between two questions who is on the bus."""

PROBE = "probe"
"""Its name on the bus and in its certificate, which also names the order client."""

AGENTS = (PROBE, ORDER_CLIENT)


class ProbeSpec(msgspec.Struct, frozen=True):
    """The settings of a probe.

    Attributes:
        plant: the plant's id.
        certificates: the folder.
        peers: HOST:PORT of those that it calls.
        lease_s: of its links.
        order: the order that it places.
    """

    plant: str
    certificates: str
    peers: tuple[str, ...]
    lease_s: float
    order: OrderItem


def write(spec: ProbeSpec) -> str:
    """The argument of a probe for this spec."""
    return msgspec.json.encode(spec).decode()


def read(line: bytes) -> tuple[float, str, Message]:
    """Parse a line of a probe: arrival (unix time), sender and message."""
    at_s, _, data = line.rstrip(b"\n").partition(b" ")
    return float(at_s), *decode(data)


async def observe(spec: ProbeSpec) -> None:
    """Place the order, and write down every message until cancelled."""
    identity = Identity.in_folder(Path(spec.certificates), PROBE)
    bus = ZenohBus(Links(peers=spec.peers, identity=identity, lease_s=spec.lease_s), spec.plant)
    try:
        session = bus.join(PROBE, _tell)
        for key in (Keys(spec.plant).all_heartbeats, Keys(spec.plant).all_events):
            session.subscribe(key)
        customers = OrderClient(bus, SystemClock(asyncio.get_running_loop()))
        # Otherwise nobody would hear the first order, and the next try would come seconds later.
        present = await bus.agents_present()
        while STRATEGIST not in present:
            await asyncio.sleep(AGAIN_S)
            present = await bus.agents_present()
        await customers.order(Order("O-1", 0.0, 1e10, (spec.order,)))
        await asyncio.Event().wait()
    finally:
        bus.close()


def _tell(sender: str, message: Message) -> None:
    sys.stdout.buffer.write(b"%a %b\n" % (time.time(), encode(sender, message)))
    sys.stdout.buffer.flush()


if __name__ == "__main__":
    asyncio.run(observe(msgspec.json.decode(sys.argv[1], type=ProbeSpec)))
