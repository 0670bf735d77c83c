"""The end of a fleet, requested by another command."""

from __future__ import annotations

import asyncio
import signal
from pathlib import Path

from dray.adapters.processes import Process
from dray.cli.fleet.folder import REGISTRY
from dray.cli.fleet.process_registry import read_registry
from dray.cli.fleet.process_supervisor import STOP_S


async def end_fleet(folder: Path) -> int:
    """End the `dray fleet up` of a folder with its processes, then the processes without a supervisor.

    Returns:
        The number of processes that had been running.

    Raises:
        UnavailableError: there is no fleet, or another user's.
    """
    registry = read_registry(folder)
    running = registry.running
    if registry.supervisor.signal(signal.SIGTERM):
        await registry.supervisor.gone()
        if not (folder / REGISTRY).exists():
            return len(running)
        # After a second signal it has ended without its processes.
        registry = read_registry(folder)
    told = [member for member in registry.members if member.signal(signal.SIGINT)]
    async with asyncio.TaskGroup() as group:
        for member in told:
            group.create_task(_ended(member))
    (folder / REGISTRY).unlink(missing_ok=True)
    return len(running)


async def _ended(process: Process) -> None:
    """Wait until it has ended; kill it after a timeout."""
    try:
        async with asyncio.timeout(STOP_S):
            await process.gone()
    except TimeoutError:
        process.signal(signal.SIGKILL)
        await process.gone()
