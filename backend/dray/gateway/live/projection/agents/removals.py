"""Vehicles that people have carried away, as panels see them: by whom, places freed and kept, and who refuses the report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from msgspec.structs import replace

from dray.gateway.live.reasons import REMOVAL_REFUSALS
from dray.gateway.live.views import RemovalRefusalView, RemovalView
from dray.messages import Event, RemovalRefusal
from dray.messages.fact import PlaceKept, PlacesFreed, RemovalRefused

REFUSED_KEPT = 256
"""Maximum refused reports that are kept without being shown. Another gateway may have published them a moment ago."""


class Removals:
    """The vehicles carried away and not heard since. The reader of SQL puts them here."""

    heeded: ClassVar[tuple[type, ...]] = (PlacesFreed, PlaceKept, RemovalRefused)
    """Kinds of facts that report the handling of a removal."""

    def __init__(self) -> None:
        self._views: dict[str, RemovalView] = {}
        self._freed: dict[tuple[str, int], tuple[str, ...]] = {}
        """Vehicle and removal number -> freed places, for the vehicles shown."""
        self._kept: set[tuple[str, int]] = set()
        self._refused: dict[tuple[str, int], dict[str, RemovalRefusal]] = {}
        """Vehicle and removal number -> who refuses it, and why."""

    def __contains__(self, atv: object) -> bool:
        """Whether a vehicle is off the floor."""
        return atv in self._views

    def put(self, views: Iterable[tuple[str, RemovalView]]) -> set[str]:
        """Show exactly these removals, by vehicle; returns the vehicles whose removal changed."""
        before, self._views = self._views, dict(views)
        numbers = {(atv, view.number) for atv, view in self._views.items()}
        self._kept &= numbers
        self._freed = {key: places for key, places in self._freed.items() if key[0] in self._views}
        return {atv for atv in before.keys() | self._views.keys() if before.get(atv) != self._views.get(atv)}

    def fold(self, event: Event) -> tuple[str, ...]:
        """Take in a reservation table keeper's report; returns the vehicle concerned, if it is shown."""
        fact = event.fact
        if isinstance(fact, RemovalRefused):
            self._refuse(event.agent, fact)
            return (fact.atv,) if fact.atv in self._views else ()
        if not isinstance(fact, PlacesFreed | PlaceKept) or fact.atv not in self._views:
            return ()
        if isinstance(fact, PlaceKept):
            self._kept.add((fact.atv, fact.number))
        else:
            self._refused.get((fact.atv, fact.number), {}).pop(event.agent, None)
            before = self._freed.get((fact.atv, fact.number), ())
            self._freed[fact.atv, fact.number] = tuple(sorted({*before, *fact.places}))
        return (fact.atv,)

    def _refuse(self, agent: str, fact: RemovalRefused) -> None:
        self._refused.setdefault((fact.atv, fact.number), {})[agent] = fact.reason
        shown = {(atv, view.number) for atv, view in self._views.items()}
        hidden = [key for key in self._refused if key not in shown]
        for key in hidden[:-REFUSED_KEPT]:
            del self._refused[key]

    def views(self) -> Mapping[str, RemovalView]:
        """The vehicles off the floor, as decided by people."""
        return self._views

    def view(self, atv: str) -> RemovalView | None:
        """The removal of one vehicle; None when it is on the floor."""
        view = self._views.get(atv)
        if view is None:
            return None
        freed = {place for (name, _), places in self._freed.items() if name == atv for place in places}
        refused = tuple(
            RemovalRefusalView(agent=agent, reason=reason, text=REMOVAL_REFUSALS[reason])
            for agent, reason in sorted(self._refused.get((atv, view.number), {}).items())
        )
        kept = (atv, view.number) in self._kept
        return replace(view, freed=tuple(sorted(freed)), refused=refused, kept=kept)
