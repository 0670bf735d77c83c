"""Commissioning of a machine or a storage with sensors on a broker: it waits for each topic and shows its value."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

from dray.adapters.commissioning_step import Step, Steps
from dray.adapters.machine_acts import LINK_S, Spec, Wanted, after, lacking_lines
from dray.adapters.mqtt.link import SignalsOverMqtt
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.mqtt.values import sample_of
from dray.adapters.signals.signal import LEVEL, TEXTS, Quality, Signal, Tag, is_told, no_level
from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.plant import Plant
from dray.ports import Clock

HEAR_S = 60.0
"""Longest wait for a message on each topic: meanwhile let the machine work, or press its sensors."""

CLIENT = "dray-check"


@dataclass
class MqttCommissioning:
    """The commissioning of one machine or storage.

    Args:
        mapping: its topics.
        broker: the address of their broker.
        spec: the machine, storage or gate.
        plant: its plant.
        clock: the plant's.
        wanted: the extent.
        hear_s: longest wait for a message on each topic.

    Attributes:
        steps: the results so far.
    """

    mapping: MqttMapping
    broker: BrokerAddress
    spec: Spec
    plant: Plant
    clock: Clock
    wanted: Wanted
    hear_s: float = HEAR_S
    steps: Steps = field(default_factory=Steps)

    async def run(self) -> AsyncIterator[Step]:
        """Run all steps; a failed step on which others depend ends them."""
        ear = _Ear()
        told = {name: tag for name, tag in self.mapping.tags.items() if is_told(name)}
        topics = tuple(dict.fromkeys(tag.topic for tag in told.values()))
        link = MqttLink(self.broker, "", CLIENT, topics, retained=ear.on_retained)
        running = asyncio.create_task(link.run(ear))
        try:
            begun_s = self.clock.now_s()
            if not await _within(ear.linked, LINK_S):
                yield self.steps.note(Step("connection", False, ear.lost or f"{self.broker} does not answer"))
                return
            safe = "" if self.broker.tls else "; nothing is encrypted"
            took_s = self.clock.now_s() - begun_s
            yield self.steps.note(
                Step("connection", True, f"{self.broker} answers after {took_s:.1f} s{safe}")
            )
            until_s = self.clock.now_s() + self.hear_s
            for name, tag in told.items():
                await _within(ear.event(tag.topic), until_s - self.clock.now_s())
                yield self.steps.note(_heard(name, tag, ear, self.hear_s))
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
        for name, tag in self.mapping.tags.items():
            if not is_told(name):
                yield self.steps.note(Step(name, None, f"is written to {tag.topic}: see there that it comes"))

        def signals(mapping: MqttMapping) -> SignalsOverMqtt:
            return SignalsOverMqtt(mapping, self.broker, CLIENT)

        async for step in after(self.steps, self.wanted, self.mapping, signals, self):
            yield step

    def report(self) -> str:
        """The whole report, in Markdown."""
        return "\n".join(
            [
                f"# {self.spec.id}, {self.broker}",
                "",
                *self.steps.lines,
                *lacking_lines(self.spec, self.mapping),
                "",
            ]
        )


class _Ear:
    """Listens to all topics."""

    def __init__(self) -> None:
        self.linked = asyncio.Event()
        self.lost = ""
        self.said: dict[str, bytes] = {}
        self.kept: set[str] = set()
        self._events: dict[str, asyncio.Event] = {}

    def event(self, topic: str) -> asyncio.Event:
        return self._events.setdefault(topic, asyncio.Event())

    def on_link(self) -> None:
        self.linked.set()

    def on_link_lost(self, reason: str) -> None:
        self.lost = reason

    def on_message(self, topic: str, data: bytes) -> None:
        self.said[topic] = data
        self.event(topic).set()

    def on_retained(self, topic: str, _data: bytes) -> None:
        self.kept.add(topic)


def _heard(name: str, tag: Tag, ear: _Ear, hear_s: float) -> Step:
    where = f"{tag.topic} {tag.path}".strip()
    if tag.topic not in ear.said:
        kept = ", only what the broker has kept" if tag.topic in ear.kept else ""
        # A sensor that publishes only changes may have been silent, but a count must be seen once.
        passed = False if name in (Signal.PIECES, Signal.BAD) else None
        return Step(name, passed, f"{where}: nothing was said within {hear_s:g} s{kept}")
    sample = sample_of(ear.said[tag.topic], tag.path, text=name in TEXTS)
    if sample.quality is not Quality.GOOD:
        return Step(name, False, f"{where}: {sample.reason}")
    shown = f"{where}, shows {sample.value!r}"
    if name.startswith(LEVEL) and (reason := no_level(sample.value, tag)):
        return Step(name, False, f"{shown}: {reason}")
    return Step(name, True, shown)


async def _within(event: asyncio.Event, span_s: float) -> bool:
    try:
        async with asyncio.timeout(max(0.0, span_s)):
            await event.wait()
    except TimeoutError:
        return event.is_set()
    return True
