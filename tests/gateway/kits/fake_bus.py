"""A bus on which a test speaks for the agents: it delivers at once, and what has been sent can be awaited."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TypeVar

from dray.messages import (
    AtvHeartbeat,
    Event,
    EventsAsked,
    MachineHeartbeat,
    Message,
    OrderReleased,
    OrderTaken,
    StationHeartbeat,
)
from dray.messages.keys import STRATEGISTS, Keys
from dray.plant import load_plant
from dray.ports import Receive

PLANT = load_plant("single-track").file

KEYS = Keys(PLANT.plant)

M = TypeVar("M", bound=Message)


def matches(pattern: str, key: str) -> bool:
    """Whether a subscription hears a key: `*` is one chunk, `**` any number, at the end only."""
    wanted, given = pattern.split("/"), key.split("/")
    if wanted[-1] == "**":
        wanted, given = wanted[:-1], given[: len(wanted) - 1]
    return len(wanted) == len(given) and all(w in ("*", g) for w, g in zip(wanted, given, strict=True))


@dataclass
class FakeSession:
    """One agent's place on the fake bus."""

    bus: FakeBus
    agent: str
    receive: Receive
    keys: set[str] = field(default_factory=set)

    def publish(self, key: str, message: Message) -> None:
        for session in list(self.bus.sessions.values()):
            if any(matches(pattern, key) for pattern in session.keys):
                session.receive(self.agent, message)

    def send(self, to: str, message: Message) -> None:
        # The gateway's questions whether the strategist is there come at any time.
        if not isinstance(message, EventsAsked) or to not in STRATEGISTS:
            self.bus.note(self.agent, to, message)
        if to in self.bus.sessions:
            self.bus.sessions[to].receive(self.agent, message)

    def subscribe(self, key: str) -> None:
        self.keys.add(key)

    def unsubscribe(self, key: str) -> None:
        self.keys.discard(key)

    def leave(self) -> None:
        if self.bus.sessions.get(self.agent) is self:
            del self.bus.sessions[self.agent]


class FakeBus:
    """A bus that delivers at once, and remembers what was said to one agent alone."""

    def __init__(self) -> None:
        self.sessions: dict[str, FakeSession] = {}
        self.sent: list[tuple[str, str, Message]] = []
        """Sender, receiver and message, in the order sent; the receiver need not exist."""
        self._more = asyncio.Event()

    def join(self, agent: str, receive: Receive, life: int = 0) -> FakeSession:
        session = self.sessions[agent] = FakeSession(self, agent, receive)
        return session

    def note(self, sender: str, to: str, message: Message) -> None:
        self.sent.append((sender, to, message))
        self._more.set()

    def sent_to(self, to: str, kind: type[M]) -> list[M]:
        """All messages of one kind to one agent so far."""
        return [message for _, there, message in self.sent if there == to and isinstance(message, kind)]

    async def next_to(self, to: str, kind: type[M], after: int = 0) -> M:
        """The message of one kind to one agent that comes after the first `after` ones, once it is sent."""
        while len(self.sent_to(to, kind)) <= after:
            self._more.clear()
            await self._more.wait()
        return self.sent_to(to, kind)[after]

    def say(self, *messages: Message) -> None:
        """Publish heartbeats and events as the agents that they name."""
        for message in messages:
            key, agent = _place(message)
            FakeSession(self, agent, _deaf).publish(key, message)

    def tell(self, sender: str, to: str, message: Message) -> None:
        """Say something to one agent alone."""
        FakeSession(self, sender, _deaf).send(to, message)

    def strategist(self) -> list[OrderReleased]:
        """Let a strategist join that takes every order; the orders that it will have been given."""
        given: list[OrderReleased] = []

        def receive(sender: str, message: Message) -> None:
            if isinstance(message, OrderReleased):
                given.append(message)
                self.tell("strategist", sender, OrderTaken(order=message.order))

        self.join("strategist", receive)
        return given


def _deaf(_sender: str, _message: Message) -> None:
    """Hears nothing."""


def _place(message: Message) -> tuple[str, str]:
    match message:
        case AtvHeartbeat(atv=agent):
            return KEYS.atv_heartbeat(agent), agent
        case MachineHeartbeat(machine=agent):
            return KEYS.machine_heartbeat(agent), agent
        case StationHeartbeat(station=agent):
            return KEYS.station_heartbeat(agent), agent
        case Event(agent=agent):
            return KEYS.events(agent), agent
        case _:
            raise AssertionError(f"nobody publishes {message}")
