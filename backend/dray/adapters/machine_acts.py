"""Commissioning of a machine, a storage's dock or the gate: the steps in which it works, for all controllers."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

import msgspec

from dray.adapters.commissioning_step import Step, Steps
from dray.adapters.signals.gate import KeptSignals, SignalledGate
from dray.adapters.signals.signal import LinkListener, Signal, SignalMapping, is_told
from dray.adapters.signals.store import KeptStore, SignalledStore
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.body import (
    Admit,
    CloseDock,
    CycleDone,
    CycleFailed,
    DockReady,
    GoodsArrived,
    OpenDock,
    Report,
    StartCycle,
)
from dray.messages.keys import GATE
from dray.plant import Plant
from dray.plant.model import MachineSpec, Making
from dray.plant.model import Storage as StorageSpec
from dray.ports import Clock

M = TypeVar("M", bound=SignalMapping)

LOOK_S = 0.1

LINK_S = 15.0
"""Longest wait for the controller."""

DOCK_S = 120.0
"""Longest wait for its dock."""

WRITTEN_S = 1.0
"""Time in which the end of a permit, or of `run`, reaches the controller, before the link is closed."""

CYCLES, CYCLE_MIN_S = 5.0, 60.0
"""Longest wait for a piece, in cycle times of the plant file, and at least in seconds."""

VEHICLE = "check"
"""The vehicle for which the dock is opened."""

CONTAINER = 1_000
"""Pieces that are admitted of the container with which the gate is tested."""


@dataclass(frozen=True, slots=True)
class GateSpec:
    """The gate of the delivery warehouses, which no plant file describes.

    Attributes:
        id: its agent's name.
    """

    id: str = GATE


Spec = MachineSpec | StorageSpec | GateSpec


@dataclass(frozen=True, slots=True)
class Wanted:
    """The extent of a commissioning.

    Attributes:
        cycle: whether the machine may work: one piece is made.
        dock: whether its dock is opened once, as for a vehicle, or one container let in at the gate; nobody may stand there.
    """

    cycle: bool = False
    dock: bool = False

    def of(self, mapping: M) -> M:
        """The signals it needs: written ones only where the machine is to act, because its agent may be running."""
        if self.cycle or self.dock:
            return mapping
        told = {
            name: tag
            for name, tag in mapping.signals.items()
            # It makes no sense without the permit, which is an output.
            if is_told(name) and name is not Signal.DOCK_READY
        }
        return msgspec.structs.replace(mapping, signals=told)


class At(Protocol):
    """The commissioned machine, storage or gate."""

    spec: Spec
    plant: Plant
    clock: Clock


class Link(Protocol):
    """The link to its controller."""

    def write(self) -> None:
        """The outputs for the controller have changed."""

    async def run(self, listener: LinkListener) -> None:
        """Stay linked until cancelled."""


def lacking(spec: Spec, mapping: SignalMapping) -> tuple[str, ...]:
    """What follows from signals that the mapping does not have, a line each.

    Args:
        spec: the machine, storage or gate.
        mapping: its signals.
    """
    found = []
    if Signal.ALIVE not in mapping.signals:
        found.append(
            "no `alive`: it does not notice that its agent is away, and goes on with what it was told last"
        )
    if isinstance(spec, MachineSpec):
        if Signal.RUN not in mapping.signals:
            found.append("no `run`: it is not told when a piece is wanted, and decides that itself")
        if Signal.PRODUCT not in mapping.signals and len(spec.makes) > 1:
            found.append("no `product`: it is not told which of its products is wanted")
        if Signal.FAULT not in mapping.signals and Signal.STATE not in mapping.signals:
            found.append(
                "no `fault` and no `state`: that it does not work is noticed only by a missing piece"
            )
    if not isinstance(spec, GateSpec) and Signal.DOCK_READY not in mapping.signals:
        found.append("no `dock_ready`: vehicles are let in as soon as they stand there")
    switches = [item for item, tag in mapping.levels.items() if tag.at_least is not None]
    if switches:
        found.append(
            f"no count, but a switch: {', '.join(switches)}; what people bring or take is known by its bound only"
        )
    return tuple(found)


def lacking_lines(spec: Spec, mapping: SignalMapping) -> tuple[str, ...]:
    """The lines of a report about `lacking`."""
    found = lacking(spec, mapping)
    return ("", "What the mapping does not have:", "", *(f"    {line}" for line in found)) if found else ()


async def after(
    steps: Steps, wanted: Wanted, mapping: M, link_by: Callable[[M], Link], machine: At
) -> AsyncIterator[Step]:
    """The last part of every commissioning: the steps in which the machine works, unless an earlier step failed.

    Args:
        steps: the earlier steps; these are added.
        wanted: the extent.
        mapping: its signals.
        link_by: makes a link to its controller for the needed signals.
        machine: the machine, storage or gate.
    """
    if not steps.passed:
        return
    needed = wanted.of(mapping)
    acts = Acts(machine.spec, machine.plant, needed, machine.clock, wanted, link_by(needed))
    async for step in acts.run():
        yield steps.note(step)


@dataclass
class Acts:
    """The steps of one machine, storage or gate; only a machine has a cycle.

    Args:
        spec: the machine, storage or gate.
        plant: its plant.
        mapping: its signals.
        clock: the plant's.
        wanted: the extent.
        link: the link to its controller.
    """

    spec: Spec
    plant: Plant
    mapping: SignalMapping
    clock: Clock
    wanted: Wanted
    link: Link
    _heard: list[Report] = field(default_factory=list)

    async def run(self) -> AsyncIterator[Step]:
        """Run all steps; a machine that is not ready to work ends them."""
        body = self._body()
        body.attach(self._heard.append)
        running = asyncio.create_task(self.link.run(body))
        what = {SignalledWorkcell: "machine", SignalledStore: "storage", SignalledGate: "gate"}[type(body)]
        try:
            ready = await self._until(lambda: not _why_not(body), LINK_S)
            yield Step(what, ready, "nothing keeps it from working" if ready else _why_not(body))
            if not ready:
                return
            if isinstance(body, SignalledWorkcell) and isinstance(self.spec, MachineSpec):
                yield (
                    await self._cycle(body, self.spec.makes[0])
                    if self.wanted.cycle
                    else Step("cycle", None, "left out: give --cycle, and it makes a piece")
                )
            if isinstance(body, SignalledGate):
                yield (
                    await self._container(body)
                    if self.wanted.dock
                    else Step(
                        "container",
                        None,
                        "left out: give --dock before its agent begins for the first time, and it lets a container in",
                    )
                )
                return
            yield (
                await self._dock(body)
                if self.wanted.dock
                else Step("dock", None, "left out: give --dock, and it opens its dock")
            )
        finally:
            if self.wanted.cycle or self.wanted.dock:
                await self._stop(body)
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    async def _stop(self, body: SignalledWorkcell | SignalledStore | SignalledGate) -> None:
        """Leave nothing switched on, whatever the steps have ended with."""
        if Signal.RUN in body.outputs:
            body.outputs[Signal.RUN] = self.mapping.signals[Signal.RUN].invert
            self.link.write()
        await asyncio.sleep(WRITTEN_S)

    def _body(self) -> SignalledWorkcell | SignalledStore | SignalledGate:
        world, spec = _World(self.link), self.spec
        if isinstance(spec, GateSpec):
            return SignalledGate(self.mapping, self.clock, world)
        if isinstance(spec, StorageSpec):
            return SignalledStore(spec, self.mapping, self.clock, world)
        bills = (line for making in spec.makes for line in self.plant.products[making.product].bill)
        plenty = {line.material: 10 * line.quantity for line in bills}
        mapping = msgspec.structs.replace(self.mapping, stock=plenty)
        return SignalledWorkcell(spec, self.plant, mapping, self.clock, world)

    async def _cycle(self, body: SignalledWorkcell, making: Making) -> Step:
        begun_s = self.clock.now_s()
        body.instruct(StartCycle(product=making.product))
        longest_s = max(CYCLE_MIN_S, CYCLES * making.cycle_s)
        await self._until(
            lambda: any(isinstance(report, CycleDone | CycleFailed) for report in self._heard), longest_s
        )
        took_s = self.clock.now_s() - begun_s
        for report in self._heard:
            if isinstance(report, CycleFailed):
                return Step("cycle", False, f"no {making.product} was begun: {report.reason}")
            if isinstance(report, CycleDone):
                what = "bad " if report.bad else ""
                return Step(
                    "cycle",
                    True,
                    f"one {what}{report.product} after {took_s:.0f} s; the plant file says {making.cycle_s:g} s",
                )
        return Step(
            "cycle",
            False,
            f"no piece was counted in {longest_s:.0f} s: {body.sense().broken or 'it does not begin'}",
        )

    async def _container(self, body: SignalledGate) -> Step:
        """Let one container in, whatever its label."""
        if not await self._until(lambda: bool(body.label), DOCK_S):
            return Step(
                "container",
                False,
                f"no label was read for {DOCK_S:.0f} s: put a container with one before it",
            )
        label, begun_s = body.label, self.clock.now_s()
        body.instruct(Admit(label, CONTAINER))
        is_gone = await self._until(lambda: body.label != label or bool(body.away), DOCK_S)
        body.instruct(Admit(label, 0))
        await asyncio.sleep(WRITTEN_S)
        if not is_gone:
            return Step("container", False, f"{label} was still read {DOCK_S:.0f} s after it was admitted")
        arrived = max(each.arrived for each in self._heard if isinstance(each, GoodsArrived))
        if body.away:
            return Step("container", False, body.away)
        took_s = self.clock.now_s() - begun_s
        return Step(
            "container",
            arrived > 0,
            f"{label}: {arrived} pieces counted, and its label was gone {took_s:.1f} s after it was read: count them",
        )

    async def _dock(self, body: SignalledWorkcell | SignalledStore) -> Step:
        if Signal.DOCK_READY not in self.mapping.signals:
            return Step(
                "dock", None, "it has no `dock_ready`: vehicles are let in as soon as they stand there"
            )
        begun_s = self.clock.now_s()
        spec = self.spec
        assert not isinstance(spec, GateSpec)  # noqa: S101 - it has no dock
        item = spec.stocks[0].material if isinstance(spec, StorageSpec) else spec.makes[0].product
        body.instruct(OpenDock(vehicle=VEHICLE, item=item, quantity=1))
        opened = await self._until(lambda: DockReady(vehicle=VEHICLE) in self._heard, DOCK_S)
        took_s = self.clock.now_s() - begun_s
        body.instruct(CloseDock(vehicle=VEHICLE))
        if not opened:
            return Step(
                "dock", False, f"`dock_ready` did not come on within {DOCK_S:.0f} s after `dock_permit`"
            )
        begun_s = self.clock.now_s()
        if not await self._until(lambda: body.is_dock_shut, DOCK_S):
            return Step(
                "dock", False, f"`dock_ready` stayed on for {DOCK_S:.0f} s after `dock_permit` was taken back"
            )
        return Step(
            "dock",
            True,
            f"ready after {took_s:.1f} s, and shut {self.clock.now_s() - begun_s:.1f} s after the permit went",
        )

    async def _until(self, seen: Callable[[], bool], longest_s: float) -> bool:
        until_s = self.clock.now_s() + longest_s
        while not seen():
            if self.clock.now_s() >= until_s:
                return False
            await asyncio.sleep(LOOK_S)
        return True


class _World:
    """A link without a memory: a commissioning has only one life."""

    def __init__(self, link: Link) -> None:
        self.write = link.write

    def remember(self, kept: Kept | KeptStore | KeptSignals) -> None:
        """Keep nothing: no later life follows."""


def _why_not(body: SignalledWorkcell | SignalledStore | SignalledGate) -> str:
    """The reason why it cannot work; empty for none."""
    return body.sense().broken if isinstance(body, SignalledWorkcell) else body.away
