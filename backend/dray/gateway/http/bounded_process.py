"""A bounded process beside the gateway, for work on input from others that may exhaust time and memory."""

from __future__ import annotations

import asyncio
import os
import resource
import signal
from asyncio.subprocess import DEVNULL, PIPE, STDOUT, Process
from contextlib import suppress

NICE = 10
"""How much nicer such a process is than the gateway: people on the panels come first."""

NICEST = 19
"""The end of the scale."""


async def run_bounded(command: tuple[str, ...], most_s: float, most_bytes: int) -> tuple[int, str]:
    """Run a program to its end.

    Args:
        command: the program and its arguments.
        most_s: maximum wall seconds.
        most_bytes: maximum memory.

    Returns:
        Its exit code and output.

    Raises:
        TimeoutError: it took longer; it was ended with all its children.
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
    """Start a program and read its output; the caller must end it.

    Args:
        command: the program and its arguments.
        most_bytes: maximum memory.
        stdin: its input, as in `subprocess`.
        stderr: its error output; None for the gateway's own.
    """
    process = await asyncio.create_subprocess_exec(
        *command,
        stdin=stdin,
        stdout=PIPE,
        stderr=stderr,
        # A group of its own: it ends with all its children, and ignores the terminal's signals to the
        # gateway. It stays in the gateway's session: Linux shares the processor among sessions first
        # (autogroups, sched(7)), and being nice counts within one only.
        process_group=0,
    )
    with suppress(OSError, AttributeError):
        resource.prlimit(process.pid, resource.RLIMIT_AS, (most_bytes, most_bytes))
    with suppress(OSError, AttributeError):
        own = os.getpriority(os.PRIO_PROCESS, 0)
        os.setpriority(os.PRIO_PROCESS, process.pid, min(own + NICE, NICEST))
    return process


async def end(process: Process) -> None:
    """End a process and all its children, if it is still running."""
    if process.returncode is None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
