"""Attacks on a fleet's bus, by vehicles with valid certificates and no bodies: too many tokens and messages."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.bus import ZenohBus, ZenohSession
from dray.adapters.zenoh.links import Links
from dray.cli.fleet.folder import CERTIFICATES
from dray.cli.fleet.process_registry import read_registry
from dray.messages import Event
from dray.messages.fact import MemoryLost
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of
from dray_sim.bench.stop.attacks import AGAIN_S, Attack, Target, count

TOKENS = 1_300
"""Lives of one vehicle that are all there at once, each with a token that it has signed."""

HELD_S = 1.0
"""Time for which the tokens are held before they are dropped and declared again."""

TALKERS = ("ATV901", "ATV902")
"""Names of the attackers; neither is in the plant's file."""

WORDS_PER_S = 780
"""Messages per second of each attacker."""

TURN_S = 0.05
"""Interval at which an attacker sends its messages in a batch."""


async def many_tokens(target: Target) -> None:
    """Declare and drop the tokens of one vehicle without end."""
    with _on_bus(target, TALKERS[0]) as bus:
        keys = [bus.tokens.key(bus.tokens.of(TALKERS[0], life)) for life in range(1, TOKENS + 1)]
        liveliness = bus.inner.liveliness()
        while True:
            held = [liveliness.declare_token(key) for key in keys]
            count(len(held))
            await asyncio.sleep(HELD_S)
            for each in held:
                each.undeclare()
            await asyncio.sleep(AGAIN_S)


async def talk_to_all(target: Target) -> None:
    """Vehicles that publish messages which every agent has to verify."""

    def say(session: ZenohSession, bus: ZenohBus, number: int) -> None:
        session.publish(bus.keys.events(session.agent), _word(session.agent, number))

    await asyncio.gather(*(_talk(target, name, say) for name in TALKERS))


async def talk_to_one(target: Target) -> None:
    """Vehicles that write letters to the gateway's places on the bus, of which each has to be opened."""

    def say(session: ZenohSession, _bus: ZenohBus, number: int) -> None:
        session.send(("gateway", "gateway-stop")[number % 2], _word(session.agent, number))

    await asyncio.gather(*(_talk(target, name, say) for name in TALKERS))


BUS_ATTACKS: dict[str, Attack] = {
    f"{TOKENS:,} valid tokens of one vehicle": many_tokens,
    f"two vehicles that say {WORDS_PER_S} words a second to all": talk_to_all,
    f"two vehicles that write {WORDS_PER_S} letters a second to the gateway": talk_to_one,
}


def _word(agent: str, number: int) -> Event:
    return Event(agent=agent, incarnation=1, number=number, at_s=1.0, fact=MemoryLost("damaged"))


async def _talk(target: Target, name: str, say: Callable[[ZenohSession, ZenohBus, int], None]) -> None:
    """Say something so many times a second."""
    with _on_bus(target, name) as bus:
        session, said = bus.join(name, lambda *_: None), 0
        while True:
            for _ in range(round(WORDS_PER_S * TURN_S)):
                said += 1
                say(session, bus, said)
            count(round(WORDS_PER_S * TURN_S))
            await asyncio.sleep(TURN_S)


@contextmanager
def _on_bus(target: Target, name: str) -> Iterator[ZenohBus]:
    """A place on the fleet's bus under a certificate that its authority has issued for this vehicle."""
    folder = Path(target.folder)
    registry, certificates = read_registry(folder), folder / CERTIFICATES
    Authority.load(certificates).issue(certificates, registry.plant, names_of(name, Kind.ATV))
    links = Links(
        peers=tuple(member.address for member in registry.members),
        identity=Identity.in_folder(certificates, name),
    )
    bus = ZenohBus(links, registry.plant)
    try:
        yield bus
    finally:
        bus.close()
