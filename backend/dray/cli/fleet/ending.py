"""The end of a fleet, asked for from elsewhere."""

from __future__ import annotations

import asyncio
import signal
from pathlib import Path

from dray.cli.fleet.folder import REGISTRY
from dray.cli.fleet.process_registry import read_registry
from dray.cli.fleet.process_supervisor import STOP_S
from dray.cli.fleet.processes import Process


async def end_fleet(folder: Path) -> int:
    """End the `dray fleet up` of a folder, which ends its processes; then those that nobody keeps any more.

    Returns:
        How many processes had been running.

    Raises:
        UnavailableError: there is no fleet, or it is somebody else's.
    """
    registry = read_registry(folder)
    running = registry.running
    if registry.supervisor.signal(signal.SIGTERM):
        await registry.supervisor.gone()
        if not (folder / REGISTRY).exists():
            return len(running)
        # It was told a second time, and has ended without its processes.
        registry = read_registry(folder)
    told = [member for member in registry.members if member.signal(signal.SIGINT)]
    async with asyncio.TaskGroup() as group:
        for member in told:
            group.create_task(_ended(member))
    (folder / REGISTRY).unlink(missing_ok=True)
    return len(running)


async def _ended(process: Process) -> None:
    """Wait until it has ended; it is killed when that takes too long."""
    try:
        async with asyncio.timeout(STOP_S):
            await process.gone()
    except TimeoutError:
        process.signal(signal.SIGKILL)
        await process.gone()
