"""A peer on a fleet's bus that notes which lives there are, and each agent's last message."""

from __future__ import annotations

import asyncio
import time

import zenoh
from zenoh.handlers import Callback

from dray.adapters.zenoh.bus import ZenohBus
from dray.cli.fleet.folder import OBSERVER
from dray.errors import UnavailableError
from dray.messages import Event, Message
from dray_sim.bench.losses.fleet import Fleet
from dray_sim.run.witness import Witness


async def gathered(fleet: Fleet, bus: ZenohBus, within_s: float) -> Watch:
    """A watch on a fleet, when all its agents are on the bus.

    Args:
        fleet: whose agents.
        bus: the fleet's; joined by this call.
        within_s: real seconds.

    Raises:
        UnavailableError: one of them is not there in time.
    """
    watch = Watch(bus)
    agents = frozenset(member.name for member in fleet.registry.members if member.joins)
    try:
        async with asyncio.timeout(within_s):
            await watch.until_joined(agents)
    except TimeoutError:
        missing = sorted(agents - watch.lives.keys())
        reason = f"not on the bus in {within_s:.0f} s"
        raise UnavailableError(", ".join(missing), reason, fleet.last_words(missing[0])) from None
    return watch


class Watch:
    """Listens, and takes no part.

    Its data is good enough to choose victims and to tell when a life has begun. Exact figures come from the
    histories: a message that is sent while links break does not reach everybody.

    Args:
        bus: joined by this call.

    Attributes:
        heard: the last heartbeat of each.
        lives: of each agent, when each of its lives was first seen on the bus (wall clock), by its number.
        told: the life and the number of the newest fact of each agent.
    """

    def __init__(self, bus: ZenohBus) -> None:
        self.heard = Witness()
        self.lives: dict[str, dict[int, float]] = {}
        self.told: dict[str, tuple[int, int]] = {}
        self._bus = bus
        self._joined = asyncio.Event()
        session = bus.join(OBSERVER, self._on_message)
        for key in (bus.keys.all_heartbeats, bus.keys.all_events):
            session.subscribe(key)
        see = Callback(self._see, indirect=False)
        bus.inner.liveliness().declare_subscriber(bus.tokens.everybody, see, history=True)

    def joined_since(self, agent: str, since_s: float) -> float | None:
        """When the first life of an agent was seen that was not there before this moment (wall clock)."""
        seen_s = sorted(self.lives.get(agent, {}).values())
        return next((life_s for life_s in seen_s if life_s > since_s), None)

    async def until_joined(self, agents: frozenset[str]) -> None:
        """Wait until all of these are on the bus."""
        while not agents <= self.lives.keys():
            self._joined.clear()
            await self._joined.wait()

    def _on_message(self, sender: str, message: Message) -> None:
        self.heard.on_message(0.0, sender, "", message)
        if isinstance(message, Event):
            newest = (message.incarnation, message.number)
            self.told[message.agent] = max(newest, self.told.get(message.agent, newest))

    def _see(self, token: zenoh.Sample) -> None:
        """Runs on a thread of Zenoh's."""
        if token.kind != zenoh.SampleKind.PUT:
            return
        there = self._bus.tokens.read(str(token.key_expr))
        if there is not None:
            self._bus.arrivals.order(self._note_life, there.agent, there.life, time.time())

    def _note_life(self, agent: str, life: int, seen_s: float) -> None:
        # A token is seen again when a link has been mended.
        self.lives.setdefault(agent, {}).setdefault(life, seen_s)
        self._joined.set()
