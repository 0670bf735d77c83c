"""Faults of a floor for its vehicles: places where two have no room (`dray.plant.planning.room`), and obstructions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dray.plant.file.reasons import Reason, joined, listed
from dray.plant.planning.room import Finding, room_faults
from dray.plant.plant import Plant


def floor_advice(plant: Plant) -> Iterator[Finding]:
    """All that is too narrow, as (kind, section, text, subjects)."""
    yield from room_faults(plant)
    yield from _merged(plant)
    yield from _docks_in_the_way(plant)
    yield from _no_turning(plant)


def _merged(plant: Plant) -> Iterator[Finding]:
    """Two-lane roads without a stop point between two crossings: they count as one crossing."""
    found = [crossing for crossing in plant.crossings.values() if len(crossing.nodes) > 1]
    if found:
        told = listed([joined("and", crossing.nodes) for crossing in found])
        text = Reason("merged", places=told)
        yield "crossing", "lanes", text, tuple(crossing.nodes for crossing in found)


def _docks_in_the_way(plant: Plant) -> Iterator[Finding]:
    """Docks in the only way to others: while a vehicle stands there no other one passes."""
    docks = dict.fromkeys(plant.node_of(place) for place in plant.places)
    found = []
    for dock in docks:
        beside = {lane.end for lane in plant.roads.leaving[dock]} | {
            lane.start for lane in plant.roads.entering[dock]
        }
        if len(beside) > 1 and not _is_open(plant, dock, docks):
            found.append(dock)
    if found:
        text = Reason("dock_in_way", nodes=listed(found))
        yield "way", "nodes", text, tuple((dock,) for dock in found)


def _no_turning(plant: Plant) -> Iterator[Finding]:
    """Doors before which no lane leads back: a vehicle that stands there when one fails has to wait for people."""
    roads = plant.roads
    found = {
        (start, end): Reason("at", name=door.name, place=start)
        for (start, end), door in plant.door_on.items()
        if all(lane.end == end for lane in roads.leaving[start])
    }
    if found:
        text = Reason("no_turning", doors=listed(list(found.values())))
        yield "door", "doors", text, tuple(found)


def _is_open(plant: Plant, blocked: str, docks: Iterable[str]) -> bool:
    """Whether all other docks still reach one another while a node is blocked."""
    others = [dock for dock in docks if dock != blocked]
    if not others:
        return True
    roads = plant.roads
    return set(others) <= roads.reached_from(others[0], blocked) and set(others) <= roads.reaching(
        others[0], blocked
    )
