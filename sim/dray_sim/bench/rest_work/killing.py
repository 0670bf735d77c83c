"""One agent after another is killed, and started again after a while."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from dray_sim.run.stage import Stage


async def kill_in_turn(
    stage: Stage, victims: Sequence[str], every_s: float, dead_s: float, is_over: Callable[[], bool]
) -> int:
    """Kill them one after the other, in turn, until it is over; all live when this returns.

    Args:
        stage: where.
        victims: whom.
        every_s: from one kill to the next (plant clock).
        dead_s: how long each is away.
        is_over: asked before each kill.

    Returns:
        The number of kills.
    """
    kills = 0
    while not is_over():
        victim = victims[kills % len(victims)]
        stage.factory.crash(victim)
        await asyncio.sleep(dead_s)
        stage.factory.restart(victim)
        kills += 1
        await asyncio.sleep(every_s - dead_s)
    return kills
