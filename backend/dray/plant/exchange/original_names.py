"""The vehicles' names of an imported layout's nodes, lanes and maps: the file's ids where they differ from ours.

A vehicle that was set up with the layout knows no other ids. `dray.adapters.vda5050.control.names` says them to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dray.plant.exchange.notes import Notes
from dray.plant.exchange.track_layout import TrackLayout, TrackNode
from dray.plant.file.reasons import Reason

LONGEST = 200
"""Characters of a name in a plant file."""

Data = dict[str, Any]


class OriginalNames:
    """The original names of one layout; none for a layout that Dray has written.

    Args:
        layout: as it was read.
        ids: our id of each node.
        moved_m: the offset of each level.
        notes: takes reports of rejected data.
    """

    def __init__(
        self,
        layout: TrackLayout,
        ids: Mapping[str, str],
        moved_m: Mapping[str, tuple[float, float]],
        notes: Notes,
    ) -> None:
        self._is_ours, self._ids, self._notes = layout.ours, ids, notes
        self._frames: dict[str, Data] = {}
        levels: dict[str, str] = {}
        for node in () if layout.ours else layout.nodes:
            x_m, y_m = moved_m[node.level]
            self._frames.setdefault(node.map, {"id": node.map, "x_m": x_m, "y_m": y_m})
            if levels.setdefault(node.map, node.level) != node.level:
                text = Reason(
                    "note_map_several_levels_poses_on", map=node.map or "(none)", level=levels[node.map]
                )
                notes.add(node.place, text)
        self._has_several = len(self._frames) > 1

    def node(self, node: TrackNode) -> Data:
        """The names in a node's entry; none where the vehicles use ours."""
        if self._is_ours:
            return {}
        same = [other["original"] for other in node.kept.get("same_spot", ())]
        names = [name for name in dict.fromkeys((node.name, *same)) if len(name) <= LONGEST]
        said: Data = {"originals": names[:50]} if names != [self._ids[node.original]] else {}
        return {**said, "map": node.map} if self._has_several and node.map else said

    def name_lanes(self, lanes: list[Data], mapping: list[Data]) -> None:
        """Add the edges' names to each lane: the first one of each direction."""
        if self._is_ours:
            return
        told = {(entry["start"], entry["end"]): entry["original"] for entry in mapping if "start" in entry}
        for lane in lanes:
            for edge in reversed(told.get((lane["start"], lane["end"]), ())):
                if len(edge["original"]) <= LONGEST:
                    key = "original" if edge["start"] == lane["start"] else "original_back"
                    lane[key] = edge["original"]

    def maps(self) -> list[Data]:
        """The section of maps; empty where the only map is the plant's frame, and has no name."""
        frames = [
            {key: value for key, value in frame.items() if key == "id" or value}
            for frame in self._frames.values()
        ]
        # A map without an id among others is ambiguous.
        frames = [frame for frame in frames if frame["id"] or len(frames) == 1]
        return [] if frames == [{"id": ""}] else frames
