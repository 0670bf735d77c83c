"""The scenario that `dray up --scenario` plays: the gateway's `ScenarioPlayer`, across the threads."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Mapping

from dray.cli.simulation.factory_thread import inside
from dray.cli.simulation.rehearsal import Expected
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import ScenarioCheckView, ScenarioView, StepView
from dray.scenario_steps import ScenarioStep
from dray_sim.run.live import LivePlay


class SimScenarioPlayer:
    """Reports the progress of a scenario that runs in another thread, and can accelerate it.

    Args:
        play: used in its thread only.
        loop: that thread's loop.
        shows: the scenario's purpose, in one line.
        time: the two clocks.
        hurry: sets whether the clock skips time in which the factory is idle; called in its thread.
    """

    def __init__(
        self,
        play: LivePlay,
        loop: asyncio.AbstractEventLoop,
        shows: str,
        time: TimeScale,
        hurry: Callable[[bool], None],
    ) -> None:
        self._play, self._loop, self._shows, self._hurry = play, loop, shows, hurry
        self._began_s = time.to_wall_s(play.began_s)
        self._skipping = False
        self._expected: dict[ScenarioStep, float] = {}
        self._tell: Callable[[ScenarioView], None] = lambda _view: None

    def follow(self, tell: Callable[[ScenarioView], None]) -> None:
        """See `ScenarioPlayer.follow`."""
        ours = asyncio.get_running_loop()

        def tell_there(view: ScenarioView) -> None:
            # After the gateway's end nobody listens.
            if not ours.is_closed():
                ours.call_soon_threadsafe(tell, view)

        def begin() -> None:
            self._tell = tell_there
            self._play.on_change = self._step
            self._tell(self._view())

        self._loop.call_soon_threadsafe(begin)

    async def skip(self, *, skips: bool) -> ScenarioView:
        """See `ScenarioPlayer.skip`."""
        return await inside(self._loop, lambda: self._skip(skips=skips))

    def expect(self, expected: Expected) -> None:
        """Take a rehearsal's prediction of a step. Thread-safe."""

        def note() -> None:
            self._expected[expected.step] = expected.after_s
            self._tell(self._view())

        # After the factory's end no step will come.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(note)

    # --- in the factory's thread ---

    def _step(self) -> None:
        self._set(skips=False)
        self._tell(self._view())

    def _skip(self, *, skips: bool) -> ScenarioView:
        self._set(skips=skips and self._play.ending is None)
        view = self._view()
        self._tell(view)
        return view

    def _set(self, *, skips: bool) -> None:
        self._skipping = skips
        self._hurry(skips)

    def _view(self) -> ScenarioView:
        view = view_of(self._play, self._shows, self._expected)
        view.began_at_s, view.skipping = self._began_s, self._skipping
        return view


def view_of(play: LivePlay, shows: str, expected: Mapping[ScenarioStep, float]) -> ScenarioView:
    """The scenario's progress.

    Args:
        play: the scenario.
        shows: its purpose, in one line.
        expected: the times of steps in a rehearsal (factory seconds after its beginning).
    """
    happened, ending = play.stage.steps.happened, play.ending
    # The live scenario's delay against its rehearsal, by their last common step: a small difference in load, or people took part.
    late_s = 0.0
    for known, at in happened.items():
        if known in expected:
            late_s = at.at_s - play.began_s - expected[known]
    steps = []
    for step in play.part.steps:
        view = StepView(step=step)
        if step in expected:
            view.expected_s = expected[step] + (late_s if step not in happened else 0.0)
        if (seen := happened.get(step)) is not None:
            view.after_s, view.agents = seen.at_s - play.began_s, seen.agents
        steps.append(view)
    told = ScenarioView(id=play.part.name, shows=shows, steps=tuple(steps))
    if ending is not None:
        told.state = "held" if ending.held else "failed"
        told.after_s = ending.at_s - play.began_s
        told.checks = tuple(
            ScenarioCheckView(name=check.name, held=check.held, figure=check.figure)
            for check in ending.checks
        )
    return told
