"""The gateway's place on the bus: whom it listens to, and how it speaks."""

from __future__ import annotations

from collections.abc import Callable

from dray.messages import Closures, Message, ObstacleCleared, Removals, ShutOut
from dray.messages.keys import Keys
from dray.ports import Bus, Session


class Peer:
    """Takes part in the bus.

    Args:
        bus: where agents meet.
        keys: the plant's.
        name: its own on the bus.
        life: its incarnation: the latest gateway of this name stays.
    """

    def __init__(self, bus: Bus, keys: Keys, name: str, life: int) -> None:
        self._bus, self._keys, self._name, self._life = bus, keys, name, life
        self._session: Session | None = None
        self.ignored = 0
        """Messages that nobody here waits for. Normal."""

    @property
    def joined(self) -> bool:
        """Whether it takes part at this moment."""
        return self._session is not None

    def join(self, receive: Callable[[str, Message], bool]) -> None:
        """Take part, and hand on what is heard.

        Args:
            receive: takes a message of a sender; returns whether anybody waited for it.
        """

        def counted(sender: str, message: Message) -> None:
            self.ignored += not receive(sender, message)

        self._session = self._bus.join(self._name, counted, self._life)
        self._session.subscribe(self._keys.all_heartbeats)
        self._session.subscribe(self._keys.all_events)
        self._session.subscribe(self._keys.all_calls)
        self._session.subscribe(self._keys.all_obstacles)

    def send(self, to: str, message: Message) -> None:
        """Say it to one agent; lost while it does not take part."""
        if self._session is not None:
            self._session.send(to, message)

    def tell_all(self, said: ShutOut | Closures | Removals | ObstacleCleared) -> None:
        """Say to everybody who is shut out, what is closed or cleared, or which vehicles were carried away; lost while it does not take part."""
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
        """Take part no longer; harmless when done twice."""
        if self._session is not None:
            self._session.leave()
            self._session = None
