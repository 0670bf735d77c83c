"""The network of a lean world: WLAN to and from vehicles, wire between machines; late, lost, doubled by chance from a seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from dray.messages import Message
from dray_sim.bench.traffic.clock import LeanClock

WIRE_S = 0.002
"""Between two machines."""

BASE_FRAC = 0.25
"""Part of the mean latency that even the quickest message takes; the rest is exponential, as in `network.latency`."""

LONGEST = 6.0
"""Longest latency, in multiples of the mean: a later message is lost."""


@dataclass(frozen=True, slots=True)
class Quality:
    """How good the network is.

    Attributes:
        latency_s: mean of one message to or from a vehicle.
        loss_frac: part of these messages that is lost.
        double_frac: part of these messages that comes twice.
        wire_loss_frac: part of the messages between machines that is lost.
    """

    latency_s: float = 0.02
    loss_frac: float = 0.0
    double_frac: float = 0.0
    wire_loss_frac: float = 0.0


class Air:
    """Carries messages.

    Args:
        clock: of the world.
        quality: of the links.
        seed: of chance.

    Attributes:
        receivers: by name; a message to somebody else is lost.
        deaf: agents that neither receive nor send.
        mute: kinds of messages that are dropped: a scheme does without them.
        parts: agent -> its part of a torn wired network; all others are in part 0.
        listeners: key -> its subscribers.
        said: messages to and from vehicles, each counted once.
        told: published messages that vehicles heard.
        wired: messages between machines.
    """

    def __init__(self, clock: LeanClock, quality: Quality, seed: int) -> None:
        self._clock = clock
        self._quality = quality
        self._random = Random(f"air/{seed}")
        self.receivers: dict[str, Callable[[str, Message], None]] = {}
        self.vehicles: frozenset[str] = frozenset()
        self.deaf: set[str] = set()
        self.mute: frozenset[type[Message]] = frozenset()
        self.parts: dict[str, int] = {}
        self.listeners: dict[str, dict[str, None]] = {}
        self.said = 0
        self.wired = 0
        self.told = 0

    def send(self, sender: str, to: str, message: Message) -> None:
        """Let it arrive, or not."""
        if type(message) in self.mute:
            return
        random, quality = self._random, self._quality
        if sender in self.vehicles or to in self.vehicles:
            self.said += 1
            loss_frac, latency_s = quality.loss_frac, quality.latency_s
        else:
            self.wired += 1
            loss_frac, latency_s = quality.wire_loss_frac, WIRE_S
        if sender in self.deaf or to in self.deaf or self.parts.get(sender, 0) != self.parts.get(to, 0):
            return
        times = 2 if quality.double_frac and random.random() < quality.double_frac else 1
        for _ in range(times):
            if loss_frac and random.random() < loss_frac:
                continue
            self._clock.call_at(
                self._clock.now_s + self.delay_s(latency_s), self._arrive, sender, to, message
            )

    def subscribe(self, name: str, key: str) -> None:
        self.listeners.setdefault(key, {})[name] = None

    def unsubscribe(self, name: str, key: str) -> None:
        self.listeners[key].pop(name, None)

    def publish(self, sender: str, key: str, message: Message) -> None:
        """Deliver to all subscribers, each with a delay of its own."""
        random, quality = self._random, self._quality
        for to in self.listeners.get(key, ()):
            if to in self.deaf or (quality.loss_frac and random.random() < quality.loss_frac):
                continue
            self.told += 1
            self._clock.call_at(
                self._clock.now_s + self.delay_s(quality.latency_s), self._arrive, sender, to, message
            )

    def hint(self, sender: str, deliver: Callable[[], None]) -> None:
        """A vehicle's heartbeat, heard by all machines or by none."""
        quality = self._quality
        if sender in self.deaf or (quality.loss_frac and self._random.random() < quality.loss_frac):
            return
        self._clock.call_at(self._clock.now_s + self.delay_s(quality.latency_s), deliver)

    def delay_s(self, latency_s: float) -> float:
        extra_s = self._random.expovariate(1.0 / (latency_s * (1.0 - BASE_FRAC)))
        return min(latency_s * BASE_FRAC + extra_s, latency_s * LONGEST)

    def _arrive(self, sender: str, to: str, message: Message) -> None:
        receive = self.receivers.get(to)
        if receive is not None and to not in self.deaf:
            receive(sender, message)
