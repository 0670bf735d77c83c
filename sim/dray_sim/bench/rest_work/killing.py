"""Kills agents in turn, and starts each again after a while."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from dray_sim.run.stage import Stage


async def kill_in_turn(
    stage: Stage, victims: Sequence[str], every_s: float, dead_s: float, is_over: Callable[[], bool]
) -> int:
    """Kill the victims in turn until `is_over`. All of them are alive when this returns.

    Args:
        stage: the run with the agents.
        victims: names of the agents.
        every_s: interval of the kills (plant clock).
        dead_s: time from a kill to the restart (plant clock).
        is_over: whether to stop; asked before each kill.

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
