"""The scenario that a simulated factory plays, as panels see it."""

from __future__ import annotations

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import ScenarioView


class Scenarios:
    """The scenario being played, if any. Its player reports the progress here."""

    def __init__(self) -> None:
        self._scenarios: dict[str, ScenarioView] = {}
        self.changes = Changes("scenario")

    def put(self, scenario: ScenarioView) -> None:
        """Show a scenario's progress."""
        self._scenarios[scenario.id] = scenario
        self.changes.mark(scenario.id)

    def views(self) -> tuple[ScenarioView, ...]:
        """Its present state."""
        return tuple(self._scenarios.values())

    def take_changed(self) -> tuple[ScenarioView, ...]:
        """Scenarios that changed since the last call."""
        return tuple(self._scenarios[scenario] for scenario in self.changes.take_changed())
