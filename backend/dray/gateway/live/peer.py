"""The gateway's connection to the bus: its subscriptions, and what it sends."""

from __future__ import annotations

from collections.abc import Callable

from dray.messages import Closures, Message, ObstacleCleared, Removals, ShutOut
from dray.messages.keys import Keys
from dray.ports import Bus, Session


class Peer:
    """Takes part in the bus.

    Args:
        bus: the agents' bus.
        keys: the plant's keys.
        name: the gateway's name on the bus.
        life: the gateway's incarnation; the bus keeps the latest gateway of this name.
    """

    def __init__(self, bus: Bus, keys: Keys, name: str, life: int) -> None:
        self._bus, self._keys, self._name, self._life = bus, keys, name, life
        self._session: Session | None = None
        self.ignored = 0
        """Messages that no part of the gateway wanted. Normal."""

    @property
    def joined(self) -> bool:
        """Whether the gateway is on the bus."""
        return self._session is not None

    def join(self, receive: Callable[[str, Message], bool]) -> None:
        """Join the bus, and hand on what is heard.

        Args:
            receive: takes a sender and its message; returns whether some part wanted it.
        """

        def counted(sender: str, message: Message) -> None:
            self.ignored += not receive(sender, message)

        self._session = self._bus.join(self._name, counted, self._life)
        self._session.subscribe(self._keys.all_heartbeats)
        self._session.subscribe(self._keys.all_events)
        self._session.subscribe(self._keys.all_calls)
        self._session.subscribe(self._keys.all_obstacles)

    def send(self, to: str, message: Message) -> None:
        """Send a message to one agent; lost while the gateway is not on the bus."""
        if self._session is not None:
            self._session.send(to, message)

    def tell_all(self, said: ShutOut | Closures | Removals | ObstacleCleared) -> None:
        """Publish exclusions, closures, removals or a cleared obstacle; lost while not on the bus."""
        keys = self._keys
        if self._session is not None:
            key = {
                ShutOut: keys.shut_out,
                Closures: keys.closures,
                Removals: keys.removals,
                ObstacleCleared: keys.obstacle(self._name),
            }[type(said)]
            self._session.publish(key, said)

    def leave(self) -> None:
        """Leave the bus; harmless when done twice."""
        if self._session is not None:
            self._session.leave()
            self._session = None
