"""The scenario that `dray up --scenario` plays: the gateway's `ScenarioPlayer`, across the threads."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from dray.gateway.live.views import ScenarioCheckView, ScenarioView, StepView
from dray_sim.run.live import LivePlay


class SimScenarioPlayer:
    """Tells how far a play is that runs in another thread.

    Args:
        play: used in its thread only.
        loop: of that thread.
        shows: what the scenario shows, in one line.
    """

    def __init__(self, play: LivePlay, loop: asyncio.AbstractEventLoop, shows: str) -> None:
        self._play, self._loop, self._shows = play, loop, shows

    def follow(self, tell: Callable[[ScenarioView], None]) -> None:
        """See `ScenarioPlayer.follow`."""
        ours = asyncio.get_running_loop()

        def tell_now() -> None:
            view = view_of(self._play, self._shows)
            # When the gateway has ended nobody wants to know.
            if not ours.is_closed():
                ours.call_soon_threadsafe(tell, view)

        def begin() -> None:
            self._play.on_change = tell_now
            tell_now()

        self._loop.call_soon_threadsafe(begin)


def view_of(play: LivePlay, shows: str) -> ScenarioView:
    """How far it is.

    Args:
        play: what is played.
        shows: what the scenario shows, in one line.
    """
    happened, ending = play.stage.steps.happened, play.ending
    steps = []
    for step in play.part.steps:
        seen = happened.get(step)
        if seen is None:
            steps.append(StepView(step=step))
        else:
            steps.append(StepView(step=step, after_s=seen.at_s - play.began_s, agents=seen.agents))
    view = ScenarioView(id=play.part.name, shows=shows, steps=tuple(steps))
    if ending is not None:
        view.state = "held" if ending.held else "failed"
        view.after_s = ending.at_s - play.began_s
        view.checks = tuple(
            ScenarioCheckView(name=check.name, held=check.held, figure=check.figure)
            for check in ending.checks
        )
    return view
