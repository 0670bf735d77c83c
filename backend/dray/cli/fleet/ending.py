"""The end of a fleet, asked for from elsewhere."""

from __future__ import annotations

import asyncio
import signal
from pathlib import Path

from dray.cli.fleet.folder import ROLL
from dray.cli.fleet.keeper import STOP_S
from dray.cli.fleet.processes import Process
from dray.cli.fleet.roll import read_roll


async def end_fleet(folder: Path) -> int:
    """End the `dray fleet up` of a folder, which ends its processes; then those that nobody keeps any more.

    Returns:
        How many processes had been running.

    Raises:
        UnavailableError: there is no fleet, or it is somebody else's.
    """
    roll = read_roll(folder)
    running = roll.running
    if roll.keeper.signal(signal.SIGTERM):
        await roll.keeper.gone()
    else:
        async with asyncio.TaskGroup() as group:
            for member in running:
                group.create_task(_end(member))
        (folder / ROLL).unlink(missing_ok=True)
    return len(running)


async def _end(process: Process) -> None:
    if not process.signal(signal.SIGINT):
        return
    try:
        await asyncio.wait_for(process.gone(), STOP_S)
    except TimeoutError:
        process.signal(signal.SIGKILL)
        await process.gone()
