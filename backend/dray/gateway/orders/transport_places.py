"""The places of a transport: a caller at a machine knows the need there, but not the source."""

from __future__ import annotations

from collections.abc import Callable
from math import hypot

from dray.gateway.http.problems import FieldError
from dray.gateway.live.projection.agents.stations import Stations
from dray.plant import Plant


def places_for(
    plant: Plant, stations: Stations, item: str, quantity: int, source: str, to: str
) -> tuple[str, str]:
    """Find the two places.

    Args:
        plant: the keepers of materials and their places.
        stations: the storages' stocks.
        item: a material.
        quantity: pieces.
        source: empty for the nearest storage with enough, or that at least keeps it.
        to: empty for the nearest storage with room, or that at least keeps it.

    Returns:
        Both places; empty for one that was not named and not found.
    """
    if item not in plant.materials:
        return source, to
    keepers = plant.keepers_of(item)
    if not source and to in keepers:

        def has(storage: str) -> bool:
            view = stations.view(storage)
            return view is not None and quantity <= sum(
                each.level - each.promised for each in view.stocks if each.item == item
            )

        return _nearest(plant, item, to, has), to
    if not to and source in keepers:

        def takes(storage: str) -> bool:
            view = stations.view(storage)
            return view is not None and quantity <= sum(
                each.capacity - each.level for each in view.stocks if each.item == item
            )

        return source, _nearest(plant, item, source, takes)
    return source, to


def misplaced(plant: Plant, item: str, source: str, to: str) -> list[FieldError]:
    """Faults of two places for a known material."""
    if not source and not to:
        return [FieldError.of("to", "place_needed")]
    keepers, errors = plant.keepers_of(item), []
    for field, place in (("from", source), ("to", to)):
        if place and place not in keepers:
            kept = ", ".join(keepers)
            errors.append(FieldError.of(field, "place_not_keeping", place=place, item=item, places=kept))
        elif not place and not {source, to}.isdisjoint(keepers):
            errors.append(FieldError.of(field, "no_other_storage", item=item))
    if source == to:
        errors.append(FieldError.of("to", "same_place", place=to))
    return errors


def thing_misplaced(plant: Plant, source: str, to: str) -> list[FieldError]:
    """Faults of two places for a thing: both must be named and have a dock, since its place is unknown."""
    errors = []
    for field, place in (("from", source), ("to", to)):
        if not place:
            errors.append(FieldError.of(field, "thing_place"))
        elif place not in plant.machines and place not in plant.stores:
            errors.append(FieldError.of(field, "place_unknown", place=place))
    if source and source == to:
        errors.append(FieldError.of("to", "same_place", place=to))
    return errors


def _nearest(plant: Plant, item: str, place: str, fits: Callable[[str], bool]) -> str:
    x_m, y_m = plant.position_of(place)

    def rank(storage: str) -> tuple[bool, float, str]:
        there_x_m, there_y_m = plant.position_of(storage)
        return not fits(storage), hypot(there_x_m - x_m, there_y_m - y_m), storage

    return min((each for each in plant.storages_of(item) if each != place), key=rank, default="")
