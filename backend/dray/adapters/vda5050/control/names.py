"""A vehicle's own names of nodes, edges, stations and maps, and the frames of its maps: for messages in both directions.

The plant file has the names of its imported layout; the profile has the names that differ for one vehicle type. Inside the
driver everything has the plant's names and the plant's frame.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, pairwise

from msgspec.structs import replace

from dray.adapters.vda5050.profile import Profile
from dray.plant import Plant
from dray.plant.model import Dock, MapFrame, PlantFile, Unassigned


class Names:
    """The names of one vehicle.

    Args:
        plant: roads and places, with the names in its file.
        profile: the vehicle's profile, with the names that differ.

    Attributes:
        longest_m: the length of the plant's longest lane.
        frames: its maps' frames by the vehicle's `mapId`; under "" the only one, for any id. None where its map has the plant's frame.
    """

    def __init__(self, plant: Plant, profile: Profile) -> None:
        file, own = plant.file, profile.names
        self._maps = {frame.id: own.maps.get(frame.id, frame.id) for frame in file.maps}
        self.frames = _frames(file, profile, self._maps)
        self._map_of = {node.id: self._maps.get(node.map, node.map) for node in file.nodes if node.map}
        for node in plant.nodes if self._map_of else ():
            # Corners of a lane and stop points lie on the map of the node in their name.
            if (base := re.split(r"\.(?:to|from)-", node)[0]) in self._map_of:
                self._map_of[node] = self._map_of[base]
        self._nodes = {node.id: node.originals for node in file.nodes if node.originals}
        self._nodes |= {node: (name,) for node, name in own.nodes.items()}
        self._edges = {**dict(_edges(file)), **own.edges}
        self.longest_m = _longest_m(plant)
        places: Iterable[Dock | Unassigned] = chain(
            file.warehouses, file.storages, file.chargers, file.parkings, file.machines, file.unassigned
        )
        self._stations = {**{place.id: place.original for place in places if place.original}, **own.stations}
        self._ours: dict[str, list[str]] = {}
        for node in plant.nodes:
            for name in self._nodes.get(node, (node,)):
                self._ours.setdefault(name, []).append(node)
        self.strangers = tuple(
            f"{section}.{name}"
            for section, names, known in (
                ("nodes", own.nodes, plant.nodes),
                ("stations", own.stations, plant.places),
                ("maps", own.maps, self._maps),
                ("edges", own.edges, {f"{lane.start}--{lane.end}" for lane in plant.roads.lanes}),
            )
            for name in names
            if name not in known
        )
        """Names in the profile that the plant lacks."""

    # --- said to it ------------------------------------------------------------------------------

    def node(self, ours: str) -> str:
        """Its name of a node."""
        return self._nodes[ours][0] if ours in self._nodes else ours

    def edge(self, start: str, end: str) -> str:
        """Its name of the lane between two of our nodes."""
        named = self._edges.get(f"{start}--{end}")
        return f"{self.node(start)}--{self.node(end)}" if named is None else named

    def station(self, ours: str) -> str:
        """Its name of a place, or of a node that stands for one."""
        return self._stations.get(ours) or self.node(ours)

    def map_of(self, node: str, now: str) -> str:
        """The map of a node.

        Args:
            node: our node.
            now: the vehicle's present map; empty when unknown.
        """
        if now and now not in self.frames:
            return now  # It has one map, under another name.
        return self._map_of.get(node, "") or now or next(iter(self.frames), "")

    # --- what it says ----------------------------------------------------------------------------

    def ours(self, theirs: str, map_id: str) -> str | None:
        """Our name of the vehicle's node; an unknown node keeps its name.

        Args:
            theirs: its name.
            map_id: its present map; empty when unknown.

        Returns:
            None where several maps have such a node, and the intended one is unknown.
        """
        found = self._ours.get(theirs, [])
        if len(found) > 1:
            found = [node for node in found if self._map_of.get(node) == map_id]
        if not found:
            return None if theirs in self._ours else theirs
        return found[0] if len(found) == 1 else None

    def knows_map(self, map_id: str) -> bool:
        """Whether this map's frame is known."""
        return bool(map_id) and map_id in self.frames

    def frame(self, map_id: str) -> MapFrame | None:
        """A map's frame; None for an unknown one of several."""
        if map_id in self.frames:
            return self.frames[map_id]
        if not self.frames:
            return MapFrame()
        return self.frames.get("") or (next(iter(self.frames.values())) if len(self.frames) == 1 else None)


def _frames(file: PlantFile, profile: Profile, maps: Mapping[str, str]) -> dict[str, MapFrame]:
    frames = {maps[frame.id]: frame for frame in file.maps}
    frames |= {frame.id: frame for frame in profile.maps}
    own = profile.map
    if own != MapFrame(id=own.id):
        # The profile's frame of its only map prevails over the plant file.
        return {own.id: own, **{frame.id: frame for frame in profile.maps}}
    if own.id and own.id not in frames and len(frames) == 1:
        # Its only map has another name.
        (frame,) = frames.values()
        return {own.id: replace(frame, id=own.id)}
    return frames


def _edges(file: PlantFile) -> Iterator[tuple[str, str]]:
    for lane in file.lanes:
        if lane.original:
            yield f"{lane.start}--{lane.end}", lane.original
        if lane.original_back:
            yield f"{lane.end}--{lane.start}", lane.original_back


def _longest_m(plant: Plant) -> float:
    """The length of the longest lane, over its corners."""
    lengths_m = {(lane.start, lane.end): lane.length_m for lane in plant.roads.lanes}
    shaped = (
        sum(lengths_m.get(piece, 0.0) for piece in pairwise((start, *corners, end)))
        for (start, end), corners in plant.corners.items()
    )
    return max(chain(lengths_m.values(), shaped), default=0.0)
