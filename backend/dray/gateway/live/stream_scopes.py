"""Stream scopes: the frames of clients that see the same: the whole plant or some of its areas.

A scope derives its delta from the whole plant's delta. The whole plant's scope passes it on unchanged. An
area scope remembers what it has shown: it leaves out what looks the same from there, and reports entities as
gone once, if they had been shown.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

from msgspec.structs import replace

from dray.gateway.live.frames import COLLECTIONS, Delta, Snapshot
from dray.gateway.live.plant_picture import PlantPicture
from dray.gateway.live.views import FactoryView
from dray.gateway.live.visibility import AreaVisibility, FactoryVisibility, Show, goal_alias, news_alias


class StreamScope(Protocol):
    """What a room of clients sees."""

    def snapshot(self, number: int, wall_s: float, most: int | None = None) -> Snapshot:
        """The complete state; the delta after `number` follows it.

        Args:
            number: the frame's number.
            wall_s: the wall clock.
            most: maximum entities of each collection in `MANY`, first ones first; None for all.
        """
        ...

    def rest(self, most: int) -> dict[str, Sequence[str]]:
        """The names that such a snapshot left out, by collection, for `views`."""
        ...

    def views(self, collection: str, names: Iterable[str]) -> tuple[Any, ...]:
        """The present views of these names, without those that have gone."""
        ...

    def delta(self, told: Delta) -> Delta:
        """The visible part of a whole-plant delta; its number is not set yet."""
        ...


class WholeScope:
    """The whole plant.

    Args:
        projection: the plant's picture.
    """

    def __init__(self, projection: PlantPicture) -> None:
        self._projection = projection

    def snapshot(self, number: int, wall_s: float, most: int | None = None) -> Snapshot:
        """See `StreamScope.snapshot`."""
        return self._projection.snapshot(number, wall_s, most)

    def rest(self, most: int) -> dict[str, Sequence[str]]:
        """See `StreamScope.rest`."""
        return {
            "orders": tuple(self._projection.orders.ids())[most:],
            "tasks": tuple(self._projection.tasks.ids())[most:],
        }

    def views(self, collection: str, names: Iterable[str]) -> tuple[Any, ...]:
        """See `StreamScope.views`."""
        view = self._projection.orders.view if collection == "orders" else self._projection.tasks.view
        return tuple(seen for name in names if (seen := view(name)) is not None)

    def delta(self, told: Delta) -> Delta:
        """See `StreamScope.delta`."""
        return told


OF_ORDERS = ("order:", "alert:order_", "news:waits-")
"""Prefixes of names in `Delta.gone` that belong to orders."""


class FactoryScope:
    """The whole plant without its orders.

    Args:
        projection: the plant's picture.
        visibility: filters it.
    """

    def __init__(self, projection: PlantPicture, visibility: FactoryVisibility) -> None:
        self._projection, self._visibility = projection, visibility

    def snapshot(self, number: int, wall_s: float, most: int | None = None) -> Snapshot:
        """See `StreamScope.snapshot`."""
        whole = self._projection.snapshot(number, wall_s, most)
        return replace(whole, orders=(), **self._of(whole))

    def rest(self, most: int) -> dict[str, Sequence[str]]:
        """See `StreamScope.rest`."""
        return {"tasks": tuple(self._projection.tasks.ids())[most:]}

    def views(self, collection: str, names: Iterable[str]) -> tuple[Any, ...]:
        """See `StreamScope.views`."""
        tasks = (view for name in names if (view := self._projection.tasks.view(name)) is not None)
        return tuple(seen for view in tasks if (seen := self._visibility.task(view)) is not None)

    def delta(self, told: Delta) -> Delta:
        """See `StreamScope.delta`."""
        gone = tuple(_alias(name) for name in told.gone if not name.startswith(OF_ORDERS))
        return replace(told, orders=(), gone=gone, **self._of(told))

    def _of(self, frame: Snapshot | Delta) -> dict[str, tuple[Any, ...]]:
        visibility = self._visibility
        shows: dict[str, tuple[Show, tuple[Any, ...]]] = {
            "machines": (visibility.machine, frame.machines),
            "stations": (visibility.station, frame.stations),
            "tasks": (visibility.task, frame.tasks),
            "news": (visibility.news, frame.news),
            "alerts": (visibility.alert, frame.alerts),
        }
        return {
            kind: tuple(seen for view in views if (seen := show(view)) is not None)
            for kind, (show, views) in shows.items()
        }


def _alias(gone: str) -> str:
    """The name of a gone entity, as clients know it."""
    kind, _, name = gone.partition(":")
    return f"{kind}:{news_alias(name) if kind == 'news' else goal_alias(name)}"


class AreaScope:
    """Some areas of the plant.

    Args:
        projection: the whole plant's picture.
        visibility: filters it.
    """

    def __init__(self, projection: PlantPicture, visibility: AreaVisibility) -> None:
        self._projection, self._visibility = projection, visibility
        self._shows = visibility.shows()
        self._shown: dict[str, dict[str, Any]] = {kind: {} for kind in self._shows}
        """Entities shown and still valid, by kind and id."""
        self._plant_at_s: float | None = None
        """What the last delta told of when the plant became as it is: a snapshot is for one client only."""
        for kind in self._shows:
            self._show(kind, self._all(kind))

    def snapshot(self, number: int, wall_s: float, most: int | None = None) -> Snapshot:
        """See `StreamScope.snapshot`: everything shown so far, since only that is reported as gone later."""
        shown: dict[str, Any] = {
            COLLECTIONS[kind]: tuple(views.values()) for kind, views in self._shown.items()
        }
        shown["tasks"] = shown["tasks"][:most]
        shown["news"] = tuple(sorted(shown["news"], key=lambda each: each.at_s))
        shown["alerts"] = tuple(
            sorted(shown["alerts"], key=lambda each: (each.level != "alarm", each.since_at_s))
        )
        return Snapshot(
            number=number,
            at_s=wall_s,
            plant=self._projection.plant,
            factory=self._factory(wall_s),
            orders=(),
            **shown,
        )

    def rest(self, most: int) -> dict[str, Sequence[str]]:
        """See `StreamScope.rest`."""
        return {"tasks": tuple(self._shown["task"])[most:]}

    def views(self, collection: str, names: Iterable[str]) -> tuple[Any, ...]:
        """See `StreamScope.views`."""
        shown = self._shown["task"]
        return tuple(shown[name] for name in names if name in shown)

    def delta(self, told: Delta) -> Delta:
        """See `StreamScope.delta`."""
        before = set(self._shown["atv"])
        atvs, gone = self._show("atv", told.atvs)
        # A vehicle that enters or leaves gains or loses its name in everything that mentions it.
        crossed = bool(gone) or any(atv.id not in before for atv in atvs)
        seen: dict[str, Any] = {"atvs": atvs}
        for kind in self._shows:
            if kind != "atv":
                collection = COLLECTIONS[kind]
                views = self._all(kind) if crossed else getattr(told, collection)
                seen[collection], left = self._show(kind, views)
                gone += left
        gone += self._forget(told.gone)
        factory = self._factory(told.at_s)
        before_s, self._plant_at_s = self._plant_at_s, factory.plant_at_s
        return Delta(
            number=told.number,
            at_s=told.at_s,
            factory=factory if factory.plant_at_s != before_s else None,
            gone=tuple(gone),
            **seen,
        )

    def _factory(self, wall_s: float) -> FactoryView:
        """What an area is told of the factory: its speed, and when its plant changed last."""
        return FactoryView(speed=self._projection.speed, plant_at_s=self._projection.plant_at_s(wall_s))

    def _all(self, kind: str) -> Sequence[Any]:
        """The views of a kind in the whole plant."""
        return self._projection.kinds[COLLECTIONS[kind]].views()

    def _show(self, kind: str, views: Iterable[Any]) -> tuple[tuple[Any, ...], list[str]]:
        """Filter some views of a kind.

        Returns:
            Views that differ from those shown, and the names of those no longer seen.
        """
        show, shown, told, gone = self._shows[kind], self._shown[kind], [], []
        for view in views:
            seen, last = show(view), shown.get(view.id)
            if seen is not None and seen != last:
                shown[view.id] = seen
                told.append(seen)
            elif seen is None and last is not None:
                del shown[view.id]
                gone.append(f"{kind}:{view.id}")
        return tuple(told), gone

    def _forget(self, gone: Iterable[str]) -> list[str]:
        """Forget entities gone from the plant's stream; returns those that were shown here."""
        left = []
        for name in gone:
            kind, _, entity = name.partition(":")
            if kind in self._shown and self._shown[kind].pop(entity, None) is not None:
                left.append(name)
        return left
