"""Pausing an area: no vehicle drives into it, and all inside stand, until it goes on.

A pause is a closure of the area plus a stop for each vehicle in it, each with its own grant. To go on means
to open the area, then to acknowledge and resume the vehicles that this pause stopped. A vehicle stopped by
anybody else, before or since, stays stopped. So does one whose sensors report a problem: a person at the
vehicle must deal with it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable

import msgspec

from dray.gateway.access.principal import Principal
from dray.gateway.factory.closings import Closings
from dray.gateway.factory.commands import Commands
from dray.gateway.http.problems import Problem
from dray.gateway.live.projection import Projection
from dray.gateway.live.reasons import refusal_text
from dray.gateway.live.views import AtvView
from dray.messages import ClosureKind, CommandKind
from dray.store.factory.closures import ClosureRow


class Word(msgspec.Struct, frozen=True):
    """The result for one vehicle."""

    atv: str
    done: bool
    """False when it refused, did not answer, or was left as it is."""
    text: str = ""
    """Reason if not done, in English."""


class PauseAnswer(msgspec.Struct, frozen=True):
    """The result of a pause or of its end."""

    area: str
    closures: tuple[str, ...]
    """Closures in force for the area, or just ended."""
    vehicles: tuple[Word, ...]
    """Vehicles that were in the area."""


class AreaPause:
    """Pauses areas.

    Args:
        commands: sends commands to vehicles.
        closings: closes areas.
        projection: knows the vehicles' positions.
    """

    def __init__(self, commands: Commands, closings: Closings, projection: Projection) -> None:
        self._commands, self._closings, self._projection = commands, closings, projection
        self._stops: dict[str, dict[str, str]] = {}
        """Per area and vehicle, the name of the pause's stop. At most one per vehicle; lost with the gateway,
        which then resumes no vehicle, because it cannot know that it stopped it."""

    async def pause(self, area: str, reason: str, by: Principal) -> PauseAnswer:
        """Close an area, and stop all vehicles in it.

        Args:
            area: an area of the plant.
            reason: shown to everybody.
            by: the caller.

        Raises:
            Problem: 409, too much is closed.
            UnavailableError: the closure could not be stored, and nothing was done.
        """
        closure, _ = await self._closings.close(_closed(area, reason, by, self._closings.now_s))
        stops = self._stops.setdefault(area, {})

        async def stop(atv: AtvView) -> str:
            name = self._commands.new_name()
            if atv.status != "stopped":
                stops[atv.id] = name
            answer = await self._commands.order(atv.id, CommandKind.STOP, by=by, command=name)
            return "" if answer.done else refusal_text(answer)

        return PauseAnswer(area, (closure.id,), await _each(self._in(area), stop))

    async def go_on(self, area: str, by: Principal) -> PauseAnswer:
        """Open an area, and resume the vehicles that its pause stopped.

        Args:
            area: an area of the plant.
            by: the caller.

        Raises:
            UnavailableError: the database cannot be written, and nothing was done.
        """
        ended = [
            view.id
            for view in self._projection.closures.views()
            if view.area == area and view.kind == ClosureKind.CLOSED.value
        ]
        for closure in ended:
            await self._closings.open(closure)
        stops = self._stops.pop(area, {})

        async def resume(atv: AtvView) -> str:
            if self._commands.last_stop(atv.id) != stops.get(atv.id, ""):
                return "somebody else has stopped it, or an earlier life of this gateway: look at it, acknowledge and resume it by itself"
            for kind in (CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
                answer = await self._commands.order(atv.id, kind, by=by)
                if not answer.done:
                    return refusal_text(answer)
            return ""

        stopped = [atv for atv in self._all(stops, area) if atv.status == "stopped"]
        return PauseAnswer(area, tuple(ended), await _each(stopped, resume))

    def _in(self, area: str) -> list[AtvView]:
        plant = self._projection.site.plant
        return [
            atv
            for atv in self._projection.atvs.views()
            if atv.removal is None and area in plant.areas_near(atv.x_m, atv.y_m, 0.0)
        ]

    def _all(self, stops: Iterable[str], area: str) -> list[AtvView]:
        """The vehicles in the area, and those stopped by the pause that came to rest beyond its edge."""
        found = {atv.id: atv for atv in self._in(area)}
        for name in stops:
            view = self._projection.atvs.view(name)
            if view is not None:
                found.setdefault(name, view)
        return [found[name] for name in sorted(found)]


async def _each(atvs: Iterable[AtvView], act: Callable[[AtvView], Awaitable[str]]) -> tuple[Word, ...]:
    """Command all vehicles at once: one that does not answer delays no other's stop."""

    async def one(atv: AtvView) -> Word:
        try:
            why = await act(atv)
        except Problem as problem:
            why = problem.detail
        return Word(atv.id, not why, why)

    return tuple(await asyncio.gather(*map(one, atvs)))


def _closed(area: str, reason: str, by: Principal, now_s: float) -> ClosureRow:
    return ClosureRow(
        id="",
        kind=ClosureKind.CLOSED.value,
        start_node="",
        end_node="",
        place="",
        area=area,
        outline="",
        speed_mps=None,
        until_s=None,
        reason=reason,
        by=by.name,
        person=f"{by.kind}:{by.id}",
        at_s=now_s,
    )
