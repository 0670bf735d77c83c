"""The types of vehicles that may drive on the edges of a layout, and their speeds."""

from __future__ import annotations

from dray.plant.exchange.notes import Notes
from dray.plant.exchange.track_layout import TrackEdge, TrackLayout
from dray.plant.file.reasons import Reason


class Admission:
    """The types of vehicles of one layout.

    Args:
        layout: as it was read.
        notes: takes reports of contradictions.
    """

    def __init__(self, layout: TrackLayout, notes: Notes) -> None:
        self._notes = notes
        self._all = [kind.original for kind in layout.vehicle_types]
        self._at_node = {node.original: node.types or self._all for node in layout.nodes}

    def limits(self, edge: TrackEdge, others: list[TrackEdge]) -> dict[str, float | None]:
        """Type -> its highest speed on an edge, or on the others beside it; None where the layout gives none.

        A layout that names no types at all has the empty one, which is for all.
        """
        if not self._all:
            return {"": edge.limits_mps.get("")}
        found: dict[str, float | None] = {}
        for one in (edge, *others):
            for kind in one.types or self._all:
                found.setdefault(kind, one.limits_mps.get(kind, one.limits_mps.get("")))
        at_ends = [
            kind for kind in found if all(kind in self._at_node[node] for node in (edge.start, edge.end))
        ]
        if not at_ends:
            named = ", ".join(found)
            text = Reason("note_edge_none_its_types_may", edge=edge.original, named=named)
            self._notes.add(edge.place, text)
        elif len(at_ends) < len(found):
            gone = ", ".join(kind for kind in found if kind not in at_ends)
            text = Reason("note_edge_may_not_its_nodes", edge=edge.original, gone=gone)
            self._notes.add(edge.place, text)
            return {kind: found[kind] for kind in at_ends}
        return found

    def only_some(self, types: dict[str, float | None]) -> bool:
        """Whether some types are left out."""
        return any(kind not in types for kind in self._all)

    def beside(self, first: TrackEdge, second: TrackEdge) -> list[str]:
        """The types that a second edge between the same nodes admits, and the first one does not."""
        before = first.types or self._all
        return [kind for kind in second.types or self._all if kind not in before]
