"""The gateway's place on the bus: whom it listens to, and who in it hears what."""

from __future__ import annotations

from dray.gateway.commands import Commands
from dray.gateway.desk import STRATEGIST, Desk
from dray.gateway.endings import Endings
from dray.gateway.projection import Projection
from dray.messages import CancellationTaken, CommandAnswered, Message, OrderTaken, RevocationTaken, ShutOut
from dray.messages.keys import Keys
from dray.ports import Bus, Receive, Session


class Peer:
    """Takes part in the bus.

    Args:
        bus: where agents meet.
        keys: the plant's.
        name: its own on the bus.
        life: its incarnation: the latest gateway of this name stays.
        ear: hears everything that is heard.
    """

    def __init__(self, bus: Bus, keys: Keys, name: str, life: int, ear: Receive) -> None:
        self._bus, self._keys, self._name, self._life, self._ear = bus, keys, name, life, ear
        self._session: Session | None = None
        self.ignored = 0
        """Messages that nobody here waits for. Normal."""

    @property
    def joined(self) -> bool:
        """Whether it takes part at this moment."""
        return self._session is not None

    def join(self, projection: Projection, desk: Desk, endings: Endings, commands: Commands) -> None:
        """Take part, and hand on what is heard."""

        def receive(sender: str, message: Message) -> None:
            self._ear(sender, message)
            match message:
                case OrderTaken(fulfilled=True) | RevocationTaken():
                    if sender == STRATEGIST:
                        self.ignored += not endings.hear(message)
                case OrderTaken() | CancellationTaken():
                    if sender == STRATEGIST:
                        desk.answered(message)
                case CommandAnswered():
                    self.ignored += not commands.answered(sender, message)
                case _:
                    projection.fold(message)

        self._session = self._bus.join(self._name, receive, self._life)
        self._session.subscribe(self._keys.all_heartbeats)
        self._session.subscribe(self._keys.all_events)

    def send(self, to: str, message: Message) -> None:
        """Say it to one agent; lost while it does not take part."""
        if self._session is not None:
            self._session.send(to, message)

    def tell_all(self, said: ShutOut) -> None:
        """Say to everybody who is shut out; lost while it does not take part."""
        if self._session is not None:
            self._session.publish(self._keys.shut_out, said)

    def leave(self) -> None:
        """Take part no longer; harmless when done twice."""
        if self._session is not None:
            self._session.leave()
            self._session = None
