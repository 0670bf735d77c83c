"""A scenario that is played without a factory."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
from wall_clock import NOW_S

from dray.errors import UnavailableError
from dray.gateway.live.views import ScenarioView, StepView
from dray.scenario_steps import ScenarioStep


class FakePlayer:
    """A player of two steps, whose second one comes ten minutes after its begin when it is told to come."""

    def __init__(self) -> None:
        self.view = ScenarioView(
            id="case-0",
            shows="",
            steps=(
                StepView(step=ScenarioStep.ORDERED, after_s=0.0, expected_s=0.0, agents=("M8",)),
                StepView(step=ScenarioStep.CONTRACTED, expected_s=600.0),
            ),
            began_at_s=NOW_S,
        )
        self.away = False
        """Whether the factory does not answer."""
        self._tell: Callable[[ScenarioView], None]

    def follow(self, tell: Callable[[ScenarioView], None]) -> None:
        self._tell = tell
        tell(self.view)

    async def skip(self, *, skips: bool) -> ScenarioView:
        if self.away:
            raise UnavailableError("the simulated factory", "does not answer", "look at the log")
        return self.put(skipping=skips)

    def put(self, **changed: object) -> ScenarioView:
        """It has come so far."""
        self.view = msgspec.structs.replace(self.view, **changed)
        self._tell(self.view)
        return self.view
