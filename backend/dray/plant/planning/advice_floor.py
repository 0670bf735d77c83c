"""What is wrong with a floor for its vehicles: where two have no room (`dray.plant.planning.room`), and what holds them up."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dray.plant.planning.room import Finding, listed, room_faults
from dray.plant.plant import Plant


def floor_advice(plant: Plant) -> Iterator[Finding]:
    """All that is too narrow, as (kind, section, text, subjects)."""
    yield from room_faults(plant)
    yield from _merged(plant)
    yield from _docks_in_the_way(plant)
    yield from _no_turning(plant)


def _merged(plant: Plant) -> Iterator[Finding]:
    """Two-lane roads without a stop point between two crossings: they are crossed, and waited for, as one."""
    found = [crossing for crossing in plant.crossings.values() if len(crossing.nodes) > 1]
    if found:
        told = listed([" and ".join(crossing.nodes) for crossing in found])
        text = (
            f"there is no room for a stop point between {told}: each is one crossing for one vehicle at a time; "
            "move them apart, or make them one node"
        )
        yield "crossing", "lanes", text, tuple(crossing.nodes for crossing in found)


def _docks_in_the_way(plant: Plant) -> Iterator[Finding]:
    """Docks in the only way to others: while a vehicle stands there nobody passes."""
    docks = dict.fromkeys(plant.node_of(place) for place in plant.places)
    found = []
    for dock in docks:
        beside = {lane.end for lane in plant.roads.leaving[dock]} | {
            lane.start for lane in plant.roads.entering[dock]
        }
        if len(beside) > 1 and not _is_open(plant, dock, docks):
            found.append(dock)
    if found:
        text = f"vehicles dock at {listed(found)} in the only way to others, who wait for them: give each dock a spur"
        yield "way", "nodes", text, tuple((dock,) for dock in found)


def _no_turning(plant: Plant) -> Iterator[Finding]:
    """Doors before which no lane leads back: whoever stands there when one fails has to wait for people."""
    roads = plant.roads
    found = {
        (start, end): f"{door.name} at {start}"
        for (start, end), door in plant.door_on.items()
        if all(lane.end == end for lane in roads.leaving[start])
    }
    if found:
        text = (
            f"no lane leads back from before {listed(list(found.values()))}: who stands there when the door does not open waits for "
            "people; on a single track with another lane at its node it turns by itself"
        )
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
