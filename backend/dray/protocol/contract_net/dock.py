"""The docks of a transport."""

from __future__ import annotations

from dray.messages import Transport
from dray.plant import Plant


def dock_of(plant: Plant, work: Transport, place: str) -> str:
    """The node where vehicles dock at a source or at the destination of a transport.

    Args:
        plant: the plant file's plant.
        work: the transport; it gives the position of a joining machine.
        place: one of its places.

    Returns:
        A node; empty if the place is unknown.
    """
    if plant.has_place(place):
        return plant.node_of(place)
    return place if place == work.handed_at else work.node
