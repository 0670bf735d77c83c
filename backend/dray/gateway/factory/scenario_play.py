"""The scenario that a simulated factory plays: whoever plays it tells the gateway how far it is, and skips to its next step."""

from __future__ import annotations

from collections.abc import Callable
from http import HTTPStatus
from typing import Protocol

from dray.gateway.http.problems import Problem
from dray.gateway.live.projection.scenarios import Scenarios
from dray.gateway.live.views import ScenarioView


class ScenarioPlayer(Protocol):
    """Plays a scenario, elsewhere."""

    def follow(self, tell: Callable[[ScenarioView], None]) -> None:
        """Tell how far it is: now, at each step and at its end.

        Args:
            tell: called on the event loop on which this was called.
        """
        ...

    async def skip(self, *, skips: bool) -> ScenarioView:
        """Run as fast as can be until the next step has happened, or no longer.

        Returns:
            How far it is. When it has ended nothing has changed.

        Raises:
            UnavailableError: the factory does not answer.
        """
        ...


class ScenarioPlay:
    """The scenario that is played, and who plays it.

    Args:
        player: None where the factory is not simulated, or nobody wrote its day.
        shown: on the panels.
    """

    def __init__(self, player: ScenarioPlayer | None, shown: Scenarios) -> None:
        self._player, self._shown = player, shown

    def follow(self) -> None:
        """Show it from now on."""
        if self._player is not None:
            self._player.follow(self._shown.put)

    def view(self) -> ScenarioView:
        """How far it is.

        Raises:
            Problem: 409, no scenario is played.
        """
        for view in self._shown.views():
            return view
        raise Problem(
            HTTPStatus.CONFLICT,
            "no-scenario",
            "No scenario is played",
            "start one with `dray up --scenario NAME`; `dray sim list` names them",
        )

    async def skip(self, *, skips: bool) -> ScenarioView:
        """Skip to the next step, or stop doing so.

        Returns:
            How far it is.

        Raises:
            Problem: 409, no scenario is played, or it has ended.
            UnavailableError: the factory does not answer.
        """
        if self.view().state != "playing" or self._player is None:
            raise Problem(
                HTTPStatus.CONFLICT,
                "scenario-over",
                "The scenario has ended",
                "there is no next step; start it again with `dray up --scenario NAME`",
            )
        return await self._player.skip(skips=skips)
