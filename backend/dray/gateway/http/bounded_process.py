"""A process beside the gateway, with bounds: for work on what others have sent, which may take all time and memory there is."""

from __future__ import annotations

import asyncio
import os
import resource
import signal
from asyncio.subprocess import DEVNULL, PIPE, STDOUT, Process
from contextlib import suppress


async def run_bounded(command: tuple[str, ...], most_s: float, most_bytes: int) -> tuple[int, str]:
    """Start a program, and wait for its end.

    Args:
        command: the program and its arguments.
        most_s: wall seconds that it may take.
        most_bytes: of memory.

    Returns:
        Its exit code and what it has said.

    Raises:
        TimeoutError: it took longer; it is ended, with all that it has started.
    """
    process = await start_bounded(command, most_bytes, stdin=DEVNULL, stderr=STDOUT)
    try:
        async with asyncio.timeout(most_s):
            said, _ = await process.communicate()
    finally:
        await end(process)
    return process.returncode or 0, said.decode(errors="replace")


async def start_bounded(
    command: tuple[str, ...], most_bytes: int, *, stdin: int, stderr: int | None = None
) -> Process:
    """Start a program whose output is read; who starts it ends it.

    Args:
        command: the program and its arguments.
        most_bytes: of memory.
        stdin: what it reads, as `subprocess` has it.
        stderr: where it says what is wrong; the gateway's own when None.
    """
    process = await asyncio.create_subprocess_exec(
        *command,
        stdin=stdin,
        stdout=PIPE,
        stderr=stderr,
        # Ends with all that it has started, and does not hear what is said to the gateway's terminal.
        start_new_session=True,
    )
    # People on the panels come first.
    with suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, process.pid, 10)
        resource.prlimit(process.pid, resource.RLIMIT_AS, (most_bytes, most_bytes))
    return process


async def end(process: Process) -> None:
    """End a process with all that it has started, if it has not ended."""
    if process.returncode is None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
