"""What a vehicle calls the nodes, edges, stations and maps of the plant, and where its maps lie: for what is said to it, and what it says.

The plant file has the names of the layout that it was imported from; the profile has those that vehicles of one type call otherwise.
Inside the driver everything has the plant's names and lies in the plant's frame.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain

from msgspec.structs import replace

from dray.adapters.vda5050.profile import Profile
from dray.plant import Plant
from dray.plant.model import Dock, MapFrame, PlantFile, Unassigned


class Names:
    """Those of one vehicle.

    Args:
        plant: roads and places, with the names that its file has.
        profile: of the vehicle, with the names that differ from these.

    Attributes:
        frames: where its maps lie, by the vehicle's `mapId`; under "" the only one, whatever its id. None where its map is the plant's frame.
    """

    def __init__(self, plant: Plant, profile: Profile) -> None:
        file, own = plant.file, profile.names
        self._maps = {frame.id: own.maps.get(frame.id, frame.id) for frame in file.maps}
        self.frames = _frames(file, profile, self._maps)
        self._map_of = {node.id: self._maps.get(node.map, node.map) for node in file.nodes if node.map}
        for node in plant.nodes if self._map_of else ():
            # Corners of a lane and stop points lie on the map of the node that they are named after.
            if (base := re.split(r"\.(?:to|from)-", node)[0]) in self._map_of:
                self._map_of[node] = self._map_of[base]
        self._nodes = {node.id: node.originals for node in file.nodes if node.originals}
        self._nodes |= {node: (name,) for node, name in own.nodes.items()}
        self._edges = {**dict(_edges(file)), **own.edges}
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
        """What the profile names and the plant does not have."""

    # --- said to it ------------------------------------------------------------------------------

    def node(self, ours: str) -> str:
        """What it calls a node."""
        return self._nodes[ours][0] if ours in self._nodes else ours

    def edge(self, start: str, end: str) -> str:
        """What it calls the lane between two nodes of ours."""
        named = self._edges.get(f"{start}--{end}")
        return f"{self.node(start)}--{self.node(end)}" if named is None else named

    def station(self, ours: str) -> str:
        """What it calls a place, or a node that stands for one."""
        return self._stations.get(ours) or self.node(ours)

    def map_of(self, node: str, now: str) -> str:
        """The map that a node lies on.

        Args:
            node: of ours.
            now: the map that the vehicle is on; empty when it has not said one.
        """
        if now and now not in self.frames:
            return now  # It has one map, and calls it otherwise.
        return self._map_of.get(node, "") or now or next(iter(self.frames), "")

    # --- what it says ----------------------------------------------------------------------------

    def ours(self, theirs: str, map_id: str) -> str | None:
        """Our name of a node that it names; the same name for one that is no node of the plant.

        Args:
            theirs: what it says.
            map_id: the map that it is on; empty when it has not said one.

        Returns:
            None where several maps have such a node, and it is not known which one is meant.
        """
        found = self._ours.get(theirs, [])
        if len(found) > 1:
            found = [node for node in found if self._map_of.get(node) == map_id]
        if not found:
            return None if theirs in self._ours else theirs
        return found[0] if len(found) == 1 else None

    def knows_map(self, map_id: str) -> bool:
        """Whether it is told where this map lies."""
        return bool(map_id) and map_id in self.frames

    def frame(self, map_id: str) -> MapFrame | None:
        """Where a map lies; None for one that is none of several."""
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
        # The profile says where its only map lies, whatever the plant file has.
        return {own.id: own, **{frame.id: frame for frame in profile.maps}}
    if own.id and own.id not in frames and len(frames) == 1:
        # It calls the only map otherwise.
        (frame,) = frames.values()
        return {own.id: replace(frame, id=own.id)}
    return frames


def _edges(file: PlantFile) -> Iterator[tuple[str, str]]:
    for lane in file.lanes:
        if lane.original:
            yield f"{lane.start}--{lane.end}", lane.original
        if lane.original_back:
            yield f"{lane.end}--{lane.start}", lane.original_back
