"""Commissioning of a machine's controller: it is walked through all that the machine's agent will want of it, and each step is written down.

Nothing moves before it is asked for: the first steps only read. What is found out becomes a mapping.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
from asyncua import ua
from asyncua.client.client import Client
from asyncua.ua.uaerrors import UaError

from dray.adapters.commissioning_step import Step
from dray.adapters.opcua.link import OpcUaLink, connection, find, sample_of, words
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import READ, Quality, Signal, Tag
from dray.adapters.signals.workcell import Kept, SignalledWorkcell
from dray.body import CloseDock, CycleDone, CycleFailed, DockReady, OpenDock, Report, StartCycle
from dray.plant import Plant
from dray.plant.model import MachineSpec
from dray.ports import Clock

LOOK_S = 0.1

LINK_S = 15.0
"""Longest wait for the controller."""

DOCK_S = 120.0
"""Longest wait for its dock."""

CYCLES = 5.0
"""Longest wait for a piece, in what one takes by the plant file."""

NODES_MAX = 2_000
"""Nodes that are looked at for a suggestion: a controller may have a hundred thousand."""

HINTS = {
    Signal.PIECES: ("good", "piece", "part", "count", "produced"),
    Signal.BAD: ("scrap", "reject", "bad", "nok"),
    Signal.FAULT: ("fault", "alarm", "error"),
    Signal.STATE: ("machineryitemstate", "state"),
    Signal.DOCK_READY: ("docksafe", "dockready", "agvready", "ready"),
    Signal.RUN: ("run", "start", "enable"),
    Signal.DOCK_PERMIT: ("agvhere", "permit", "agvrequest"),
    Signal.SPEED: ("override", "speed"),
}
"""What names of nodes look like, the likeliest first."""

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


@dataclass
class Commissioning:
    """Of one machine.

    Args:
        mapping: where its controller is, and its nodes.
        folder: of the mapping file.
        password: of its user.
        spec: the machine.
        plant: where it is.
        clock: the plant's.
        wanted: how far to go.

    Attributes:
        steps: what came of them so far.
    """

    mapping: OpcUaMapping
    folder: Path
    password: str
    spec: MachineSpec
    plant: Plant
    clock: Clock
    wanted: Wanted
    steps: list[Step] = field(default_factory=list)
    _guesses: dict[Signal, str] = field(default_factory=dict)
    _heard: list[Report] = field(default_factory=list)

    async def run(self) -> AsyncIterator[Step]:
        """Walk through all steps; a step on which others stand ends it when it fails.

        Raises:
            SettingsError: a certificate cannot be used.
        """
        client = await connection(self.mapping, self.folder, self.password)
        begun_s = self.clock.now_s()
        try:
            async with asyncio.timeout(LINK_S):
                await client.connect()
        except (OSError, TimeoutError, UaError) as error:
            yield self._note(Step("connection", False, words(error)))
            return
        try:
            took_s = self.clock.now_s() - begun_s
            safe = (
                ""
                if self.mapping.security != "none"
                else "; nothing is encrypted, and nobody shows who it is"
            )
            yield self._note(
                Step("connection", True, f"{self.mapping.url} answers after {took_s:.1f} s{safe}")
            )
            for signal, tag in self.mapping.signals.items():
                yield self._note(await self._node(client, signal, tag))
            await self._guess(client)
        finally:
            await client.disconnect()
        if not self.passed:
            return
        async for step in self._acts():
            yield self._note(step)

    @property
    def passed(self) -> bool:
        """Nothing that was tried has failed."""
        return bool(self.steps) and all(step.passed is not False for step in self.steps)

    def report(self) -> str:
        """All of it, to be kept: Markdown."""
        lacking = {
            signal: node for signal, node in self._guesses.items() if signal not in self.mapping.signals
        }
        suggestion = [f'  {signal.value}: {{node: "{node}"}}' for signal, node in lacking.items()]
        return "\n".join(
            [
                f"# {self.spec.id}, {self.mapping.url}",
                "",
                *(f"    {step.line}" for step in self.steps),
                "",
                "Nodes that look like signals which the mapping does not have; look at each before you add it:"
                if suggestion
                else "Nothing that the controller shows looks like a signal which the mapping does not have.",
                *([""] if suggestion else []),
                *(f"    {line}" for line in suggestion),
                "",
            ]
        )

    # --- steps that only read ---

    async def _node(self, client: Client, signal: Signal, tag: Tag) -> Step:
        name = signal.value
        try:
            node = await find(client, tag.node)
            kind = await node.read_data_type_as_variant_type()
            sample = sample_of(await node.read_data_value(raise_on_bad_status=False))
            access = await node.get_user_access_level()
        except (UaError, ValueError, OSError) as error:
            return Step(name, False, f"{tag.node}: {words(error)}")
        shown = f"{tag.node}, {kind.name}, shows {sample.value!r}"
        if sample.quality is not Quality.GOOD:
            return Step(name, False, f"{tag.node}, {kind.name}: {sample.reason}")
        if signal not in READ and ua.AccessLevel.CurrentWrite not in access:
            return Step(name, False, f"{shown}, and may not be written by {self.mapping.user or 'us'}")
        if signal in (Signal.PIECES, Signal.BAD) and (tag.edge is not None) != (
            kind is ua.VariantType.Boolean
        ):
            what = (
                "is a pulse: say `edge: rising` or `falling`"
                if tag.edge is None
                else "is no pulse: leave `edge` out"
            )
            return Step(name, False, f"{shown}: it {what}")
        return Step(name, True, shown)

    async def _guess(self, client: Client) -> None:
        """Look for nodes whose names look like signals."""
        seen, left, found = 0, [client.nodes.objects], dict[str, str]()
        while left and seen < NODES_MAX:
            node = left.pop(0)
            try:
                children = await node.get_children()
            except (UaError, OSError):
                continue
            for child in children:
                seen += 1
                if child.nodeid.NamespaceIndex == 0:
                    continue  # The server's own.
                left.append(child)
                if await child.read_node_class() is ua.NodeClass.Variable:
                    name = (await child.read_browse_name()).Name or ""
                    found.setdefault(name.lower(), child.nodeid.to_string())
        for signal, hints in HINTS.items():
            for hint in hints:
                names = sorted((name for name in found if hint in name), key=len)
                if names and found[names[0]] not in self._guesses.values():
                    self._guesses[signal] = found[names[0]]
                    break

    # --- steps that let it work ---

    async def _acts(self) -> AsyncIterator[Step]:
        link = OpcUaLink(self.mapping, self.folder, self.password)
        bills = (line for making in self.spec.makes for line in self.plant.products[making.product].bill)
        plenty = {line.material: 10 * line.quantity for line in bills}
        mapping = msgspec.structs.replace(self.mapping, stock=plenty)
        body = SignalledWorkcell(self.spec, self.plant, mapping, self.clock, _World(link))
        body.attach(self._heard.append)
        running = asyncio.create_task(link.run(body))
        try:
            ready = await self._until(lambda: not body.sense().broken, LINK_S)
            yield Step("machine", ready, "nothing keeps it from working" if ready else body.sense().broken)
            if not ready:
                return
            yield (
                await self._cycle(body)
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

    async def _cycle(self, body: SignalledWorkcell) -> Step:
        making, begun_s = self.spec.makes[0], self.clock.now_s()
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

    async def _dock(self, body: SignalledWorkcell) -> Step:
        if Signal.DOCK_READY not in self.mapping.signals:
            return Step(
                "dock", None, "it has no `dock_ready`: vehicles are let in as soon as they stand there"
            )
        begun_s = self.clock.now_s()
        body.instruct(OpenDock(vehicle=VEHICLE, item=self.spec.makes[0].product, quantity=1))
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

    def _note(self, step: Step) -> Step:
        self.steps.append(step)
        return step


class _World:
    """A link, and nothing that is remembered: the one who commissions lives once."""

    def __init__(self, link: OpcUaLink) -> None:
        self.write = link.write

    def remember(self, kept: Kept) -> None:
        """Nobody comes after it."""
