"""Docks: where vehicles stand at the places of a transport. Pure."""

from __future__ import annotations

from dray.messages import Transport
from dray.plant import Plant


def dock_of(plant: Plant, work: Transport, place: str) -> str:
    """The node where vehicles dock at a source or at the destination of a transport.

    Args:
        plant: as the plant file has it.
        work: the transport; one of a newcomer tells where that stands.
        place: a place of it.

    Returns:
        A node; empty when nobody knows the place.
    """
    return plant.node_of(place) if plant.has_place(place) else work.node
