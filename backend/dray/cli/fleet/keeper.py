"""A keeper: it keeps one process of a fleet running, as a service manager does."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import sys

from dray.cli.fleet.folder import GATEWAY
from dray.cli.fleet.posts import Post
from dray.cli.fleet.roll import RollKeeper

REST_S = 1.0
"""Before a process that has ended is started again: one that ends at once must not take the computer."""

STOP_S = 10.0
"""To end in peace; then it is killed."""


async def keep(post: Post, roll: RollKeeper) -> None:
    """Keep one process running until cancelled; then let it end at once."""
    while True:
        # The gateway tells on the terminal where the panels are.
        with post.log.open("ab") as log:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                "dray",
                *post.command,
                env=post.environment,
                stdout=None if post.name == GATEWAY else log,
                stderr=log,
                # Ctrl-C is for us; we tell them.
                start_new_session=True,
            )
        roll.started(post.name, process.pid, post.address, joins=post.joins)
        try:
            await process.wait()
        except asyncio.CancelledError:
            await _end(process)
            raise
        await asyncio.sleep(REST_S)


async def _end(process: asyncio.subprocess.Process) -> None:
    with contextlib.suppress(ProcessLookupError):
        # Not SIGTERM, by which an agent finishes first what it has begun.
        process.send_signal(signal.SIGINT)
        try:
            await asyncio.wait_for(process.wait(), STOP_S)
        except TimeoutError:
            process.kill()
            await process.wait()
