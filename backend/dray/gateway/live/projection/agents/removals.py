"""Vehicles that people have carried away, as panels see them: by whom, places freed, and places kept."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from msgspec.structs import replace

from dray.gateway.live.views import RemovalView
from dray.messages import Event
from dray.messages.fact import PlaceKept, PlacesFreed


class Removals:
    """The vehicles carried away and not heard since. The reader of SQL puts them here."""

    heeded: ClassVar[tuple[type, ...]] = (PlacesFreed, PlaceKept)
    """Kinds of facts that report the handling of a removal."""

    def __init__(self) -> None:
        self._views: dict[str, RemovalView] = {}
        self._freed: dict[tuple[str, int], tuple[str, ...]] = {}
        """Vehicle and removal number -> freed places, for the vehicles shown."""
        self._kept: set[tuple[str, int]] = set()

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
        if not isinstance(fact, PlacesFreed | PlaceKept) or fact.atv not in self._views:
            return ()
        if isinstance(fact, PlaceKept):
            self._kept.add((fact.atv, fact.number))
        else:
            before = self._freed.get((fact.atv, fact.number), ())
            self._freed[fact.atv, fact.number] = tuple(sorted({*before, *fact.places}))
        return (fact.atv,)

    def views(self) -> Mapping[str, RemovalView]:
        """The vehicles off the floor, as decided by people."""
        return self._views

    def view(self, atv: str) -> RemovalView | None:
        """The removal of one vehicle; None when it is on the floor."""
        view = self._views.get(atv)
        if view is None:
            return None
        freed = {place for (name, _), places in self._freed.items() if name == atv for place in places}
        return replace(view, freed=tuple(sorted(freed)), kept=(atv, view.number) in self._kept)
