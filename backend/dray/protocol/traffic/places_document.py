"""The places, districts and lanes of a plant as a document, for agents that do not derive them from the plant themselves."""

from __future__ import annotations

import msgspec

from dray.plant import Plant
from dray.protocol.traffic.places import Places


class DistrictEntry(msgspec.Struct, frozen=True):
    """A district and the replicas of its table."""

    district: str
    replicas: tuple[str, ...]
    """The leader of epoch E is number E modulo their count, from 0."""
    places: tuple[str, ...]


class LaneEntry(msgspec.Struct, frozen=True):
    """What a lane needs, in one direction."""

    start: str
    end: str
    needs: tuple[str, ...]
    """Places that must be held to enter it, in order."""
    clear_m: float
    """Distance past `start` on this lane at which a vehicle is clear of `start`."""


class PlacesDocument(msgspec.Struct, frozen=True):
    """Places, districts and lanes of a plant.

    Attributes:
        districts: all districts; each place is in one of them.
        lanes: of the plant as it is driven.
        dock_entries: dock -> the node before it, which is granted with it.
        dead_ends: node of a dead end -> the next node on the way out, which is granted with it on a way in.
        crossed: node in a crossing, where no vehicle stops -> the crossing's place.
    """

    districts: tuple[DistrictEntry, ...]
    lanes: tuple[LaneEntry, ...]
    dock_entries: dict[str, str]
    dead_ends: dict[str, str]
    crossed: dict[str, str]


def places_document(plant: Plant) -> PlacesDocument:
    """Write out the places of a plant."""
    places = Places(plant)
    return PlacesDocument(
        districts=tuple(
            DistrictEntry(district, replicas, tuple(sorted(places.places_in(district))))
            for district, replicas in places.replicas_of.items()
        ),
        lanes=tuple(
            LaneEntry(
                lane.start,
                lane.end,
                places.needs(lane.start, lane.end),
                round(places.clear_m(lane.start, lane.end), 3),
            )
            for lane in plant.roads.lanes
        ),
        dock_entries=dict(places.dock_entries),
        dead_ends=dict(places.dead_ends),
        crossed={node: places.place_of(node) for node in plant.nodes if not places.may_stop(node)},
    )
