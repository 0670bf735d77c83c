"""The scenario of a simulated factory: its player reports the progress, and can skip to the next step."""

from __future__ import annotations

from collections.abc import Callable
from http import HTTPStatus
from typing import Protocol

from dray.gateway.http.problems import Problem
from dray.gateway.live.projection.scenarios import Scenarios
from dray.gateway.live.views import ScenarioView


class ScenarioPlayer(Protocol):
    """Plays a scenario outside the gateway."""

    def follow(self, tell: Callable[[ScenarioView], None]) -> None:
        """Report the progress: now, at each step and at the end.

        Args:
            tell: called on the event loop of this call.
        """
        ...

    async def skip(self, *, skips: bool) -> ScenarioView:
        """Run as fast as possible until the next step, or stop doing so.

        Returns:
            The progress; unchanged if the scenario has ended.

        Raises:
            UnavailableError: the factory does not answer.
        """
        ...


class ScenarioPlay:
    """The scenario being played, and its player.

    Args:
        player: None where the factory is not simulated, or plays no scenario.
        shown: the scenario on the panels.
    """

    def __init__(self, player: ScenarioPlayer | None, shown: Scenarios) -> None:
        self._player, self._shown = player, shown

    def follow(self) -> None:
        """Show the scenario from now on."""
        if self._player is not None:
            self._player.follow(self._shown.put)

    def view(self) -> ScenarioView:
        """The progress.

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
            The progress.

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
