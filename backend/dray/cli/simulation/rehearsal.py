"""A rehearsal: a second run of a live scenario in another process, in virtual time, which predicts its steps.

It has the same seed, and runs like the live one as long as nobody from outside is on the network. It reports each step long before
the live scenario reaches it.
"""

from __future__ import annotations

import asyncio
import logging
import sys
from asyncio.subprocess import DEVNULL
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial

import msgspec

from dray.gateway.http.bounded_process import end, start_bounded
from dray.scenario_steps import ScenarioStep
from dray_sim.clock.loop import run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.run.live import LivePlay
from dray_sim.run.stage import with_right_of_way
from dray_sim.scenarios import LIVE

MOST_BYTES = 2 * 1024**3
"""Memory limit of a rehearsal: four times what the largest scenario takes."""

_log = logging.getLogger(__name__)


class Expected(msgspec.Struct, frozen=True):
    """The time of a step in a rehearsal.

    Attributes:
        step: the step.
        after_s: factory seconds after the scenario began.
    """

    step: ScenarioStep
    after_s: float


class Rehearsed(msgspec.Struct, frozen=True):
    """The scenario to rehearse.

    Attributes:
        name: the name of its part, as in `dray up --scenario`.
        seed: determines all randomness.
        traffic: whether vehicles drive with right of way.
    """

    name: str
    seed: int
    traffic: bool


@asynccontextmanager
async def rehearsing(play: Rehearsed, tell: Callable[[Expected], None]) -> AsyncIterator[None]:
    """Run a rehearsal in another process, as long as the context lasts.

    Args:
        play: the scenario.
        tell: called for each step, on this loop.

    Raises:
        OSError: no process can be started.
    """
    command = (sys.executable, "-m", "dray.cli.simulation.rehearsal", msgspec.json.encode(play).decode())
    process = await start_bounded(command, MOST_BYTES, stdin=DEVNULL)
    listening = asyncio.create_task(_listen(process, tell))
    try:
        yield
    finally:
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)
        await end(process)


async def _listen(process: asyncio.subprocess.Process, tell: Callable[[Expected], None]) -> None:
    assert process.stdout is not None  # noqa: S101 - `start_bounded` reads it
    while line := await process.stdout.readline():
        tell(msgspec.json.decode(line, type=Expected))
    if await process.wait():
        _log.warning("the rehearsal of the scenario has failed: nobody is told when its steps will come")


def rehearse(play: Rehearsed, tell: Callable[[Expected], None]) -> None:
    """Run it in virtual time, and report each step.

    Args:
        play: the scenario.
        tell: called for each step when it has happened.
    """
    with with_right_of_way(play.traffic):
        run(_rehearse(play, tell))


async def _rehearse(rehearsed: Rehearsed, tell: Callable[[Expected], None]) -> None:
    part = LIVE[rehearsed.name].part
    # As in `one_process`: not `SimFactory` itself, in which no person would check loads.
    play = LivePlay(part, part.plant(), rehearsed.seed, partial(SimFactory))
    ended = asyncio.Event()
    told: set[ScenarioStep] = set()

    def on_change() -> None:
        for step, happened in play.stage.steps.happened.items():
            if step not in told:
                told.add(step)
                tell(Expected(step, happened.at_s - play.began_s))
        if play.ending is not None:
            ended.set()

    play.on_change = on_change
    playing = asyncio.create_task(play.run())
    await ended.wait()
    playing.cancel()


def _print(expected: Expected) -> None:
    sys.stdout.write(msgspec.json.encode(expected).decode() + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    rehearse(msgspec.json.decode(sys.argv[1], type=Rehearsed), _print)
