"""Commissioning of a machine, or of a storage's dock: the steps in which it works, whatever its controller is."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

import msgspec

from dray.adapters.commissioning_step import Step, Steps
from dray.adapters.signals.signal import LinkListener, Signal, SignalMapping, is_told
from dray.adapters.signals.store import KeptStore, SignalledStore
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.body import CloseDock, CycleDone, CycleFailed, DockReady, OpenDock, Report, StartCycle
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

CYCLES = 5.0
"""Longest wait for a piece, in what one takes by the plant file."""

VEHICLE = "check"
"""The vehicle for which the dock is opened."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """How far commissioning goes.

    Attributes:
        cycle: the machine may work: one piece is made.
        dock: its dock is opened once, as for a vehicle; nobody may stand there.
    """

    cycle: bool = False
    dock: bool = False

    def of(self, mapping: M) -> M:
        """The signals that are needed for it: those that are written only where the machine is to do something, for its agent may be at work."""
        if self.cycle or self.dock:
            return mapping
        told = {
            name: tag
            for name, tag in mapping.signals.items()
            # It makes no sense without the permit, which is written.
            if is_told(name) and name is not Signal.DOCK_READY
        }
        return msgspec.structs.replace(mapping, signals=told)


class At(Protocol):
    """The machine or the storage that is commissioned."""

    spec: MachineSpec | StorageSpec
    plant: Plant
    clock: Clock


class Link(Protocol):
    """To its controller."""

    def write(self) -> None:
        """What the controller is to be told has changed."""

    async def run(self, listener: LinkListener) -> None:
        """Be linked until cancelled."""


async def after(
    steps: Steps, wanted: Wanted, mapping: M, link_by: Callable[[M], Link], machine: At
) -> AsyncIterator[Step]:
    """The end of every commissioning: the steps in which the machine works, unless one before them has failed.

    Args:
        steps: those before; these are noted there, too.
        wanted: how far to go.
        mapping: its signals.
        link_by: makes a link to its controller for those signals that are needed.
        machine: which; or a storage.
    """
    if not steps.passed:
        return
    needed = wanted.of(mapping)
    acts = Acts(machine.spec, machine.plant, needed, machine.clock, wanted, link_by(needed))
    async for step in acts.run():
        yield steps.note(step)


@dataclass
class Acts:
    """Of one machine, or of a storage, which makes nothing.

    Args:
        spec: which.
        plant: where it is.
        mapping: its signals.
        clock: the plant's.
        wanted: how far to go.
        link: to its controller.
    """

    spec: MachineSpec | StorageSpec
    plant: Plant
    mapping: SignalMapping
    clock: Clock
    wanted: Wanted
    link: Link
    _heard: list[Report] = field(default_factory=list)

    async def run(self) -> AsyncIterator[Step]:
        """Walk through all steps; a machine that is not ready to work ends it."""
        body = self._body()
        body.attach(self._heard.append)
        running = asyncio.create_task(self.link.run(body))
        what = "machine" if isinstance(body, SignalledWorkcell) else "storage"
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
            yield (
                await self._dock(body)
                if self.wanted.dock
                else Step("dock", None, "left out: give --dock, and it opens its dock")
            )
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    def _body(self) -> SignalledWorkcell | SignalledStore:
        world, spec = _World(self.link), self.spec
        if isinstance(spec, StorageSpec):
            return SignalledStore(spec, self.mapping, self.clock, world)
        bills = (line for making in spec.makes for line in self.plant.products[making.product].bill)
        plenty = {line.material: 10 * line.quantity for line in bills}
        mapping = msgspec.structs.replace(self.mapping, stock=plenty)
        return SignalledWorkcell(spec, self.plant, mapping, self.clock, world)

    async def _cycle(self, body: SignalledWorkcell, making: Making) -> Step:
        begun_s = self.clock.now_s()
        body.instruct(StartCycle(product=making.product))
        longest_s = max(60.0, CYCLES * making.cycle_s)
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

    async def _dock(self, body: SignalledWorkcell | SignalledStore) -> Step:
        if Signal.DOCK_READY not in self.mapping.signals:
            return Step(
                "dock", None, "it has no `dock_ready`: vehicles are let in as soon as they stand there"
            )
        begun_s = self.clock.now_s()
        spec = self.spec
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
    """A link, and nothing that is remembered: the one who commissions lives once."""

    def __init__(self, link: Link) -> None:
        self.write = link.write

    def remember(self, kept: Kept | KeptStore) -> None:
        """Nobody comes after it."""


def _why_not(body: SignalledWorkcell | SignalledStore) -> str:
    """What keeps it from working; empty for nothing."""
    return body.sense().broken if isinstance(body, SignalledWorkcell) else body.away
