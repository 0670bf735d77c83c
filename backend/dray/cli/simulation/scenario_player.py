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
    """Tells how far a play is that runs in another thread, and hurries it.

    Args:
        play: used in its thread only.
        loop: of that thread.
        shows: what the scenario shows, in one line.
        time: the two clocks.
        hurry: whether the clock passes over time in which the factory has nothing to do; called in its thread.
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
            # When the gateway has ended nobody wants to know.
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
        """A rehearsal tells when a step will come; callable from any thread."""

        def note() -> None:
            self._expected[expected.step] = expected.after_s
            self._tell(self._view())

        # When the factory has ended nothing will come.
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
    """How far it is.

    Args:
        play: what is played.
        shows: what the scenario shows, in one line.
        expected: when steps have happened in a rehearsal (factory seconds after its begin).
    """
    happened, ending = play.stage.steps.happened, play.ending
    # How much later the play is than its rehearsal was, by the last step of both: somebody was busy a moment longer, or people took part.
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
