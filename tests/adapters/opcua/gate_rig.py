"""A gate's body with a clock, a disk and a link that are turned by hand, and one with the link of a real controller."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import msgspec
from plc import PATIENCE_S
from signals_rig import HandClock

from dray.adapters.mqtt.link import SignalsOverMqtt
from dray.adapters.opcua.link import OpcUaLink
from dray.adapters.signals.gate import SETTLE_S, KeptSignals, SignalledGate
from dray.adapters.signals.signal import (
    OF_A_GATE,
    Checked,
    Quality,
    Sample,
    Signal,
    SignalMapping,
    Tag,
    Value,
)
from dray.body import Admit, Report

SHAFTS, GEARS = "O-7-1.1", "O-8-1.1"

SIGNALS = {signal: Tag(signal.value) for signal in (Signal.PIECES, *OF_A_GATE, Signal.FAULT)}


class GateRig:
    """One gate, over several lives of its agent; 10 shafts and 10 gears are admitted."""

    def __init__(self, pieces: Tag | None = None, first: Value = 500) -> None:
        self.mapping = SignalMapping(SIGNALS | ({} if pieces is None else {Signal.PIECES: pieces}))
        self.clock, self.reports = HandClock(), list[Report]()
        self.kept: KeptSignals | None = None
        self.shown: Value = first
        self.label = self.broker = ""
        self.is_cut = False
        self.begin()
        for goal in (SHAFTS, GEARS):
            self.body.instruct(Admit(goal, 10))
        self.reports.clear()

    def begin(self) -> None:
        self.body = SignalledGate(self.mapping, self.clock, self, self.kept, broker=self.broker)
        self.body.attach(self.reports.append)
        self.link()

    def link(self) -> None:
        self.is_cut = False
        self.tell(Signal.PIECES, self.shown)
        self.tell(Signal.GOAL, self.label)
        self.body.on_link()
        self.write()

    def remember(self, kept: KeptSignals) -> None:
        self.kept = kept

    def write(self) -> None:
        """By OPC UA the controller confirms what it is told, unless the wire is cut and nobody has noticed."""
        if not (self.is_cut or self.broker):
            for name, value in self.body.outputs.items():
                self.body.on_written(name, value)

    def tell(self, signal: Signal, value: Value, quality: Quality = Quality.GOOD) -> None:
        self.body.on_sample(signal, Sample(value, quality))

    def show(self, label: str) -> tuple[Value, Value]:
        """A container stands there; returns what the controller is told."""
        self.label = label
        self.tell(Signal.GOAL, label)
        self.clock.pass_s(SETTLE_S)
        return self.told

    def counter(self, value: Value) -> None:
        self.shown = value
        self.tell(Signal.PIECES, value)

    def pass_by(self, label: str, pieces: int) -> None:
        """A container comes in as it should."""
        goal, admitted = self.show(label)
        assert goal == label
        assert isinstance(admitted, int)
        assert admitted >= pieces
        assert isinstance(self.shown, int)
        self.counter(self.shown + pieces)
        self.show("")

    def check(self, arrived: dict[str, int]) -> None:
        """People count, and write that into the mapping file of the next life."""
        self.mapping = msgspec.structs.replace(self.mapping, checked=Checked(self.doubt, arrived))

    @property
    def doubt(self) -> int:
        """The number of the doubt."""
        assert self.kept is not None
        assert self.kept.doubt_number > 0
        return self.kept.doubt_number

    @property
    def told(self) -> tuple[Value, Value]:
        return self.body.outputs[Signal.ADMITTED_GOAL], self.body.outputs[Signal.ADMITTED]

    @property
    def arrived(self) -> dict[str, int]:
        return {goal: pieces for goal, pieces in self.body.sense().arrived.items() if pieces}


class LinkedGate(GateRig):
    """A gate behind a link; time passes by hand, but for the link's."""

    def __init__(self, link: OpcUaLink | SignalsOverMqtt) -> None:
        self.to_controller = link
        super().__init__()

    def link(self) -> None:
        """The link does."""

    def write(self) -> None:
        self.to_controller.write()

    async def until(self, seen: Callable[[], bool]) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not seen():  # noqa: ASYNC110 - the body has no event
                await asyncio.sleep(0.02)


@asynccontextmanager
async def linked(link: OpcUaLink | SignalsOverMqtt) -> AsyncIterator[LinkedGate]:
    rig = LinkedGate(link)
    running = asyncio.create_task(link.run(rig.body))
    try:
        yield rig
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
