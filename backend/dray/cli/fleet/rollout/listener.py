"""A listener on the bus of a running fleet: it hears all heartbeats and history, and sends nothing."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

from dray.cli.fleet.folder import OBSERVER
from dray.cli.fleet.process_registry import ProcessRegistry, peer_of
from dray.messages import Event, Heartbeat, MachineHeartbeat, Message
from dray.messages.keys import Keys

OnMessage = Callable[[str, Message], None]
"""Called with (sender, message)."""


class Listener:
    """Passes on all messages, and remembers the newest of each agent.

    Create it on the loop that uses it; `close` closes it.

    Args:
        registry: the fleet.
        folder: the fleet's folder.

    Attributes:
        lives: the newest incarnation of each vehicle and machine.
        machines: the newest heartbeat of each machine.
        numbers: life and number of each agent's newest fact.
    """

    def __init__(self, registry: ProcessRegistry, folder: Path) -> None:
        self.lives: dict[str, int] = {}
        self.machines: dict[str, MachineHeartbeat] = {}
        self.numbers: dict[str, tuple[int, int]] = {}
        self._told: list[OnMessage] = []
        self._bus = peer_of(registry, folder)
        session = self._bus.join(OBSERVER, self._on_message)
        keys = Keys(registry.plant)
        for key in (keys.all_heartbeats, keys.all_events):
            session.subscribe(key)

    @contextlib.contextmanager
    def telling(self, tell: OnMessage) -> Iterator[None]:
        """Pass all messages to a callback, as long as the context lasts."""
        self._told.append(tell)
        try:
            yield
        finally:
            self._told.remove(tell)

    async def present(self) -> frozenset[str]:
        """The agents on the bus now."""
        return await self._bus.agents_present()

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    def _on_message(self, sender: str, message: Message) -> None:
        if isinstance(message, Heartbeat):
            self.lives[sender] = max(message.incarnation, self.lives.get(sender, 0))
            if isinstance(message, MachineHeartbeat):
                self.machines[sender] = message
        elif isinstance(message, Event):
            told = (message.incarnation, message.number)
            self.numbers[sender] = max(told, self.numbers.get(sender, told))
        for tell in tuple(self._told):
            tell(sender, message)
