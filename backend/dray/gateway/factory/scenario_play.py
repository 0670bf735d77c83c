"""The scenario that a simulated factory plays: whoever plays it tells the gateway how far it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from dray.gateway.live.views import ScenarioView


class ScenarioPlayer(Protocol):
    """Plays a scenario, elsewhere."""

    def follow(self, tell: Callable[[ScenarioView], None]) -> None:
        """Tell how far it is: now, at each step and at its end.

        Args:
            tell: called on the event loop on which this was called.
        """
        ...
