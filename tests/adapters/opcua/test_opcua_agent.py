"""The agent of a machine behind an OPC UA server, as a process that is killed: pieces made meanwhile are counted once."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from pathlib import Path

import msgspec
from plc import PATIENCE_S, Plc, mapping
from signals_rig import PRODUCT

from dray.adapters.signals.signal import Signal
from dray.adapters.signals.workcell import Kept

SIGNALS = tuple(Signal(name) for name in ("pieces", "run", "alive"))


async def begun(mapping_file: Path, folder: Path) -> asyncio.subprocess.Process:
    """An agent that is ready."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "dray", "agent", "machine", "M1"),
        *("--body", "opcua", "--mapping", str(mapping_file)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "DRAY_BUS_PLAIN": "true", "DRAY_JOURNAL_FOLDER": str(folder)},
        cwd=folder,
    )
    assert process.stdout is not None
    assert (await process.stdout.readline()).decode() == "M1 is ready\n"
    return process


async def until_counted(file: Path, pieces: int) -> Kept:
    """What the machine's body remembers, once it has counted so many."""
    async with asyncio.timeout(PATIENCE_S):
        kept = None
        while kept is None or kept.stock.get(PRODUCT) != pieces:
            await asyncio.sleep(0.05)
            kept = read(file)
    return kept


def read(file: Path) -> Kept | None:
    return msgspec.json.decode(file.read_bytes(), type=Kept) if file.exists() else None


def test_pieces_are_counted_once_over_a_kill_of_the_agent(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc(pieces=7) as plc:
            said = tmp_path / "mapping.yaml"
            tags = "\n".join(f'  {name}: {{node: "{tag["node"]}"}}' for name, tag in mapping(SIGNALS).items())
            said.write_text(f"url: {plc.url}\nsignals:\n{tags}\n", encoding="utf-8")
            file = tmp_path / "M1.workcell.json"
            first = await begun(said, tmp_path)
            await plc.put(Signal.PIECES, 9)
            await until_counted(file, 2)
            first.kill()
            await first.wait()
            await plc.put(Signal.PIECES, 10)
            second = await begun(said, tmp_path)
            kept = await until_counted(file, 3)
            assert (kept.seq, kept.doubt) == (3, "")
            second.terminate()
            _, told = await second.communicate()
            assert second.returncode == 0, told.decode()

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))
