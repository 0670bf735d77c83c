"""Commissioning of the controller of a machine, a storage's dock or the gate: it tries all that the agent will need, and records each step.

The first steps only read: nothing moves without being asked for. The findings become a mapping.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from pathlib import Path

from asyncua import ua
from asyncua.client.client import Client
from asyncua.common.node import Node
from asyncua.ua.uaerrors import UaError

from dray.adapters.commissioning_step import Step, Steps
from dray.adapters.machine_acts import GateSpec, Spec, Wanted, after, lacking_lines
from dray.adapters.opcua.link import OpcUaLink, connection, find, sample_of, words
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import (
    AT_A_DOCK,
    AT_A_GATE,
    LEVEL,
    OF_A_GATE,
    Quality,
    Signal,
    Tag,
    brief,
    is_told,
    no_level,
)
from dray.plant import Plant
from dray.plant.model import Storage as StorageSpec
from dray.ports import Clock

LINK_S = 15.0
"""Longest wait for the controller."""

TOP_SPEED = 2.0
"""Highest plausible speed of a machine, as a fraction of its full speed."""

NODES_MAX = 2_000
"""Maximum nodes inspected for a suggestion: a controller may have a hundred thousand."""

UNIT_MAX = 20
"""Maximum characters of a unit."""

HINTS = {
    Signal.PIECES: ("good", "piece", "part", "count", "produced"),
    Signal.BAD: ("scrap", "reject", "bad", "nok"),
    Signal.FAULT: ("fault", "alarm", "error"),
    Signal.STATE: ("machineryitemstate", "state"),
    Signal.DOCK_READY: ("docksafe", "dockready", "agvready", "ready"),
    Signal.RUN: ("run", "start", "enable"),
    Signal.DOCK_PERMIT: ("agvhere", "permit", "agvrequest"),
    Signal.SPEED: ("override", "speed"),
    Signal.PRODUCT: ("nextproduct", "product", "article", "recipe", "order"),
    Signal.RESET: ("faultreset", "reset", "acknowledge"),
    Signal.ALIVE: ("alive", "heartbeat", "watchdog"),
    Signal.DOCK_VEHICLE: ("agvname", "dock_vehicle", "vehicle"),
    Signal.ADMITTED_GOAL: ("admittedgoal", "admittedlabel"),
    Signal.ADMITTED: ("admitted", "admit"),
    Signal.GOAL: ("label", "barcode", "goal"),
}
"""Typical parts of node names, the likeliest first."""


@dataclass
class Commissioning:
    """The commissioning of one machine, storage or gate.

    Args:
        mapping: its controller's address, and its nodes.
        folder: the mapping file's folder.
        password: its user's password.
        spec: the machine, storage or gate.
        plant: its plant.
        clock: the plant's.
        wanted: the extent.

    Attributes:
        steps: the results so far.
    """

    mapping: OpcUaMapping
    folder: Path
    password: str
    spec: Spec
    plant: Plant
    clock: Clock
    wanted: Wanted
    steps: Steps = field(default_factory=Steps)
    _guesses: dict[Signal, str] = field(default_factory=dict)

    async def run(self) -> AsyncIterator[Step]:
        """Run all steps; a failed step on which others depend ends them.

        Raises:
            SettingsError: a certificate cannot be used.
        """
        client = await connection(self.mapping, self.folder, self.password)
        begun_s = self.clock.now_s()
        try:
            async with asyncio.timeout(LINK_S):
                await client.connect()
        except (OSError, TimeoutError, UaError) as error:
            yield self.steps.note(Step("connection", False, words(error)))
            return
        try:
            took_s = self.clock.now_s() - begun_s
            safe = (
                ""
                if self.mapping.security != "none"
                else "; nothing is encrypted, and nobody shows who it is"
            )
            yield self.steps.note(
                Step("connection", True, f"{self.mapping.url} answers after {took_s:.1f} s{safe}")
            )
            for name, tag in self.mapping.tags.items():
                yield self.steps.note(await self._node(client, name, tag))
            await self._guess(client)
        finally:
            await client.disconnect()

        def link(mapping: OpcUaMapping) -> OpcUaLink:
            return OpcUaLink(mapping, self.folder, self.password)

        async for step in after(self.steps, self.wanted, self.mapping, link, self):
            yield step

    def report(self) -> str:
        """The whole report, in Markdown."""
        lacking = {
            signal: node for signal, node in self._guesses.items() if signal not in self.mapping.signals
        }
        suggestion = [f'  {signal.value}: {{node: "{node}"}}' for signal, node in lacking.items()]
        return "\n".join(
            [
                f"# {self.spec.id}, {self.mapping.url}",
                "",
                *self.steps.lines,
                *lacking_lines(self.spec, self.mapping),
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

    async def _node(self, client: Client, name: str, tag: Tag) -> Step:
        name = str(name)
        try:
            node = await find(client, tag.node)
            kind = await node.read_data_type_as_variant_type()
            sample = sample_of(await node.read_data_value(raise_on_bad_status=False))
            access = await node.get_user_access_level()
        except (UaError, ValueError, OSError) as error:
            return Step(name, False, f"{tag.node}: {words(error)}")
        unit = await _unit(node)
        shown = f"{tag.node}, {kind.name}, shows {sample.value!r}{unit and f' {unit}'}"
        if sample.quality is not Quality.GOOD:
            return Step(name, False, f"{tag.node}, {kind.name}: {sample.reason}")
        if not is_told(name) and ua.AccessLevel.CurrentWrite not in access:
            return Step(name, False, f"{shown}, and may not be written by {self.mapping.user or 'us'}")
        if name.startswith(LEVEL) and (reason := no_level(sample.value, tag)):
            return Step(name, False, f"{shown}: {reason}")
        if (
            name == Signal.SPEED
            and not isinstance(sample.value, bool | str)
            and (sample.value > TOP_SPEED * tag.scale or (unit == "%" and tag.scale == 1.0))
        ):
            return Step(name, False, f"{shown}: 1 is full speed; for percent say `scale: 100`")
        if name in (Signal.PIECES, Signal.BAD) and (tag.edge is not None) != (kind is ua.VariantType.Boolean):
            what = (
                "is a pulse: say `edge: rising` or `falling`"
                if tag.edge is None
                else "is no pulse: leave `edge` out"
            )
            return Step(name, False, f"{shown}: it {what}")
        return Step(name, True, shown)

    async def _guess(self, client: Client) -> None:
        """Search for nodes whose names resemble signals."""
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
                    continue  # A node of the server itself.
                left.append(child)
                if await child.read_node_class() is ua.NodeClass.Variable:
                    name = (await child.read_browse_name()).Name or ""
                    found.setdefault(name.lower(), child.nodeid.to_string())
        for signal, hints in HINTS.items():
            if isinstance(self.spec, StorageSpec):
                is_of_it = signal in AT_A_DOCK
            elif isinstance(self.spec, GateSpec):
                is_of_it = signal in AT_A_GATE
            else:
                is_of_it = signal not in OF_A_GATE
            if not is_of_it:
                continue
            for hint in hints:
                names = sorted((name for name in found if hint in name), key=len)
                if names and found[names[0]] not in self._guesses.values():
                    self._guesses[signal] = found[names[0]]
                    break


async def _unit(node: Node) -> str:
    """The unit that a controller gives for a node (OPC 10000-8); empty for none."""
    try:
        unit = await (await node.get_child("0:EngineeringUnits")).read_value()
    except (UaError, ValueError, OSError):
        return ""
    return brief(str(getattr(getattr(unit, "DisplayName", None), "Text", "") or ""), UNIT_MAX)
