"""The scenario that a simulated factory plays, as panels see it."""

from __future__ import annotations

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import ScenarioView


class Scenarios:
    """The scenario that is played, if there is one. Whoever plays it says how far it is."""

    def __init__(self) -> None:
        self._scenarios: dict[str, ScenarioView] = {}
        self.changes = Changes("scenario")

    def put(self, scenario: ScenarioView) -> None:
        """It has come so far."""
        self._scenarios[scenario.id] = scenario
        self.changes.mark(scenario.id)

    def views(self) -> tuple[ScenarioView, ...]:
        """As of now."""
        return tuple(self._scenarios.values())

    def take_changed(self) -> tuple[ScenarioView, ...]:
        """What has changed since the last call."""
        return tuple(self._scenarios[scenario] for scenario in self.changes.take_changed())
