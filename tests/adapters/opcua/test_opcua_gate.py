"""The body of a gate whose counter and reader are nodes of an OPC UA server, in a test's process and as an agent of its own."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import msgspec
import pytest
from asyncua import ua
from gate_rig import SHAFTS, linked
from plc import PATIENCE_S, Plc, mapping

from dray.adapters.mapping_file import parse_mapping
from dray.adapters.opcua.link import OpcUaLink
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.gate import AGAIN, SETTLE_S, KeptSignals
from dray.adapters.signals.signal import Signal
from dray.body import Admit, GoodsArrived

NODES = (Signal.PIECES, Signal.GOAL, Signal.ADMITTED, Signal.ADMITTED_GOAL)


def opcua(plc: Plc, folder: Path) -> OpcUaLink:
    said = msgspec.yaml.encode({"url": plc.url, "signals": mapping(NODES)})
    return OpcUaLink(parse_mapping(said, "gate.yaml", OpcUaMapping), folder)


def test_a_controller_that_has_no_label_may_show_none_by_opc_ua(tmp_path: Path) -> None:
    """An OPC UA text may be empty, or missing."""

    async def story() -> None:
        async with Plc(pieces=70) as plc:
            await plc.put(Signal.GOAL, None)
            async with linked(opcua(plc, tmp_path)) as rig:
                await rig.until(lambda: rig.body.away == "")
                await plc.put(Signal.GOAL, SHAFTS)
                await rig.until(lambda: rig.body.label == SHAFTS)
                await plc.put(Signal.GOAL, None)
                await rig.until(lambda: rig.body.label == "")
                assert rig.body.away == ""

    asyncio.run(story())


@pytest.mark.parametrize(("kind", "most"), [(ua.VariantType.Byte, 255), (ua.VariantType.Int16, 32_767)])
def test_a_permit_that_its_node_cannot_hold_is_the_largest_that_it_can(
    kind: ua.VariantType, most: int, tmp_path: Path
) -> None:
    async def story() -> None:
        async with (
            Plc(pieces=70, types={Signal.ADMITTED: kind}) as plc,
            linked(opcua(plc, tmp_path)) as rig,
        ):
            rig.body.instruct(Admit(SHAFTS, 40_000))
            await plc.put(Signal.GOAL, SHAFTS)
            await rig.until(lambda: rig.body.label == SHAFTS and rig.body.away == "")
            rig.clock.pass_s(SETTLE_S)
            await plc.until(Signal.ADMITTED, most)
            assert rig.body.away == ""

    asyncio.run(story())


def test_a_permit_that_was_wanted_for_a_moment_and_never_written_is_confirmed_to_be_over(
    tmp_path: Path,
) -> None:
    async def story() -> None:
        async with Plc(pieces=70) as plc, linked(opcua(plc, tmp_path)) as rig:
            await plc.put(Signal.GOAL, SHAFTS)
            await rig.until(lambda: rig.body.label == SHAFTS and rig.body.away == "")
            rig.clock.pass_s(SETTLE_S)
            assert rig.told == (SHAFTS, 10)
            rig.body.instruct(Admit(SHAFTS, 0))
            rig.clock.pass_s(SETTLE_S)
            assert rig.reports[-1] == GoodsArrived(SHAFTS, 0, 10)

            def is_over() -> bool:
                rig.clock.pass_s(SETTLE_S)
                return rig.reports[-1] == GoodsArrived(SHAFTS, 0, 0)

            await rig.until(is_over)

    asyncio.run(story())


def test_a_permit_that_was_refused_once_is_given_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.adapters.opcua.link.REFUSED_AGAIN_S", 0.1)

    async def story() -> None:
        async with Plc(pieces=70) as plc:
            await plc.put(Signal.ADMITTED, 7)
            await plc.put(Signal.GOAL, SHAFTS)
            async with linked(opcua(plc, tmp_path)) as rig:
                await plc.until(Signal.ADMITTED, 0)
                await rig.until(lambda: rig.body.away == "")
                await plc.nodes[Signal.ADMITTED].set_read_only()
                rig.clock.pass_s(SETTLE_S)
                await rig.until(lambda: "does not take admitted" in rig.body.away)
                assert rig.told == ("", 0)
                await plc.nodes[Signal.ADMITTED].set_writable()
                await rig.until(lambda: rig.body.away == "")
                rig.clock.pass_s(AGAIN * SETTLE_S)
                await plc.until(Signal.ADMITTED, 10)

    asyncio.run(story())


def test_after_a_refusal_another_value_is_written_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.adapters.opcua.link.REFUSED_AGAIN_S", 3600.0)

    async def story() -> None:
        async with Plc(pieces=70) as plc:
            await plc.put(Signal.GOAL, SHAFTS)
            plc.refuse(Signal.ADMITTED, {11})
            async with linked(opcua(plc, tmp_path)) as rig:
                await rig.until(lambda: rig.body.away == "")
                rig.clock.pass_s(SETTLE_S)
                await plc.until(Signal.ADMITTED, 10)
                rig.body.instruct(Admit(SHAFTS, 11))
                await plc.until(Signal.ADMITTED, 0)
                await plc.until(Signal.ADMITTED_GOAL, "")
                assert "does not take admitted" in rig.body.away
                assert rig.body.held

    asyncio.run(story())


HURRIED = """
from dray.__main__ import main
from dray.cli.runtime.bodies import signals

signals.FIRST_S, signals.REMIND_EVERY_S = 1.0, 2.0
main()
"""
"""The command, which waits for its controller for a second instead of ten, and says so again after two instead of thirty."""


@asynccontextmanager
async def agent(folder: Path, url: str, *command: str) -> AsyncIterator[asyncio.subprocess.Process]:
    """The gate's agent, once it is ready."""
    file = folder / "gate.yaml"
    file.write_bytes(msgspec.yaml.encode({"url": url, "signals": mapping(NODES)}))
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, *command, "agent", "gate"),
        *("--body", "opcua", "--mapping", str(file)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "DRAY_BUS_PLAIN": "true", "DRAY_JOURNAL_FOLDER": str(folder)},
        cwd=folder,
    )
    try:
        assert process.stdout is not None
        assert (await process.stdout.readline()).decode() == "gate is ready\n"
        yield process
        assert process.returncode is None
    finally:
        if process.returncode is None:
            process.terminate()
        await process.communicate()


async def logged(process: asyncio.subprocess.Process, what: str) -> str:
    """The next line of its log with these words."""
    assert process.stderr is not None
    while line := (await process.stderr.readline()).decode():
        if what in line:
            return line
    raise AssertionError(f"it has ended, and did not say {what!r}")


def test_a_doubt_does_not_end_the_gate_of_a_real_controller_and_is_said(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc(pieces=70) as plc, agent(tmp_path, plc.url, "-m", "dray") as process:
            # Nobody has admitted it.
            await plc.put(Signal.GOAL, SHAFTS)
            await plc.put(Signal.PIECES, 75)
            line = await logged(process, "in doubt")
            assert "pieces went from 70 to 75: 0 pieces at most can have been let in" in line
            kept = msgspec.json.decode((tmp_path / "gate.signals.json").read_bytes(), type=KeptSignals)
            assert (kept.pieces.value if kept.pieces else None) == 75
            assert f"its count is in doubt ({kept.doubt_number}): " in line

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))


def test_the_gate_begins_without_its_controller_and_says_so(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc(pieces=70) as plc:
            url = plc.url
        async with agent(tmp_path, url, "-c", HURRIED) as process:
            await logged(process, "waits for its controller: its controller is not heard")

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))
