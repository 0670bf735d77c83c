"""One agent's session on the simulated network (see `dray.ports.Session`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dray.messages import Message
    from dray.ports import Receive
    from dray_sim.network.sim_network import SimNetwork


class SimSession:
    """One agent's session on the network (see `dray.ports.Session`)."""

    __slots__ = ("_network", "agent", "context", "deliver", "joined", "life", "number", "receive")

    def __init__(self, network: SimNetwork, number: int, agent: str, receive: Receive, life: int) -> None:
        self._network = network
        self.life = life
        self.number = number
        self.agent = agent
        self.receive = receive
        self.context = ""
        self.joined = True
        self.deliver = self._deliver
        """Bound once: it goes into the clock's heap with every delivery."""

    def publish(self, key: str, message: Message) -> None:
        """Say it to all that listen on `key`."""
        self._network.publish(self, key, message)

    def send(self, to: str, message: Message) -> None:
        """Say it to one agent alone."""
        self._network.send(self, to, message)

    def subscribe(self, key: str) -> None:
        """Receive all later messages on `key`."""
        if self.joined:
            self._network.subscribe(self, key)

    def unsubscribe(self, key: str) -> None:
        """Hear it no longer."""
        self._network.unsubscribe(self, key)

    def leave(self) -> None:
        """Leave the network."""
        if self.joined:
            self._network.leave(self)

    def deliver_with(self, context: str, sender: str, message: Message) -> None:
        """Hear something that belongs to a trace."""
        self.context = context
        self.deliver(sender, message)
        self.context = ""

    def _deliver(self, sender: str, message: Message) -> None:
        if self.joined:
            self._network.delivered += 1
            self.receive(sender, message)
        else:
            self._network.missed += 1
