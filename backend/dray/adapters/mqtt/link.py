"""The link to sensors and controllers on a broker: it subscribes to their topics, and publishes the outputs once a second.

A retained message is of unknown age. Faults and states are accepted from it, because they can only make us more careful. Counts, levels and
`dock_ready` are not: an old count would be counted twice, and an old `dock_ready` would let a vehicle in.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import suppress

from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.mqtt.values import message_of, sample_of
from dray.adapters.signals.signal import TEXTS, LinkListener, Signal, Tag, Value, is_told
from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.supervision import Failures

LOOK_S = 1.0
"""Seconds between publications of the outputs, and between checks for silence."""

ALIVE_MODULUS = 30_000

CAREFUL = (Signal.FAULT, Signal.FAULT_TEXT, Signal.STATE)
"""Signals that are accepted from retained messages."""


class SignalsOverMqtt:
    """Signals on topics.

    Args:
        mapping: the signals and their topics.
        broker: the broker's address.
        client: our client name at the broker.

    Attributes:
        linked: set at the first connection.
        failures: errors of the listener, by topic.
    """

    def __init__(self, mapping: MqttMapping, broker: BrokerAddress, client: str) -> None:
        self._mapping, self._broker = mapping, str(broker)
        self._told: dict[str, list[tuple[str, Tag]]] = {}
        self._written: dict[str, list[tuple[str, Tag]]] = {}
        for name, tag in mapping.tags.items():
            topics = self._told if is_told(name) else self._written
            topics.setdefault(tag.topic, []).append((name, tag))
        self._mqtt = MqttLink(broker, "", client, tuple(self._told), retained=self._on_retained)
        self._changed = asyncio.Event()
        self._listener: LinkListener
        self._there, self._heard_s, self._beat = False, 0.0, 0
        """Whether the listener knows that the link is up; the time of the last message; the seconds of our life."""
        self.linked = asyncio.Event()
        self.failures = Failures(str(broker))
        self._mqtt.failures = self.failures

    def write(self) -> None:
        """The listener's outputs have changed."""
        self._changed.set()

    async def run(self, listener: LinkListener) -> None:
        """Stay linked until cancelled, whatever errors a message causes in the listener.

        Raises:
            UnavailableError: raised by the listener.
        """
        self._listener = listener
        saying = asyncio.create_task(self._say_all())
        linked = asyncio.create_task(self._mqtt.run(self))
        try:
            await asyncio.wait((saying, linked), return_when=asyncio.FIRST_COMPLETED)
            for task in (saying, linked):
                if task.done():
                    task.result()
        finally:
            for task in (saying, linked):
                task.cancel()
            await asyncio.gather(saying, linked, return_exceptions=True)

    # --- what the link to the broker tells ---

    def on_link(self) -> None:
        """The broker is connected; with `silent_after_s` a message must come first."""
        if self._mapping.silent_after_s is None:
            self._begin()
        self._changed.set()

    def on_link_lost(self, reason: str) -> None:
        """The connection to the broker is lost."""
        self._there = False
        self._listener.on_link_lost(reason)

    def on_message(self, topic: str, data: bytes) -> None:
        """A message of the present."""
        self._heard_s = asyncio.get_running_loop().time()
        if not self._there:
            self._begin()
        for name, tag in self._told.get(topic, ()):
            self._listener.on_sample(name, sample_of(data, tag.path, text=name in TEXTS))

    def _on_retained(self, topic: str, data: bytes) -> None:
        """A message of unknown age."""
        for name, tag in self._told.get(topic, ()):
            if name in CAREFUL:
                self._listener.on_sample(name, sample_of(data, tag.path, text=name in TEXTS))

    def _begin(self) -> None:
        self._there = True
        self._listener.on_link()
        self.linked.set()

    # --- what they are told ---

    async def _say_all(self) -> None:
        clock = asyncio.get_running_loop()
        while True:
            self._changed.clear()
            self._beat += 1
            for topic, tags in self._written.items():
                if values := list(self._values(tags)):
                    self._mqtt.publish(topic, message_of(values))
            with suppress(TimeoutError):
                async with asyncio.timeout(LOOK_S):
                    await self._changed.wait()
            bound_s = self._mapping.silent_after_s
            if self._there and bound_s is not None and clock.time() - self._heard_s > bound_s:
                self._there = False
                silent = f"{self._broker}: nothing was said for {bound_s:g} s"
                self.failures.tell("the link", self._listener.on_link_lost, silent)

    def _values(self, tags: list[tuple[str, Tag]]) -> Iterator[tuple[str, Value]]:
        for name, tag in tags:
            alive = name == Signal.ALIVE
            value = self._beat % ALIVE_MODULUS if alive else self._listener.outputs.get(name)
            if value is not None:
                yield tag.path, value
