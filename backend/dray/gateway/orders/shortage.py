"""What lacks where a transport that waits is to be fetched, and who has as much: by the last words of storages and machines."""

from __future__ import annotations

from math import hypot

import msgspec

from dray.gateway.live.projection import Projection
from dray.messages import TransportState, TransportWait
from dray.store.orders.transports import TransportRow

NAMED_MOST = 3
"""Storages that are named: the nearest."""


class Shortage(msgspec.Struct, frozen=True, kw_only=True):
    """Why a transport cannot be fetched yet: its source has less than was asked for."""

    free: int
    """Pieces that lie at its source and are not set aside for others."""
    on_order: int
    """Pieces that are on their way there, or are to be. 0 where nothing is known to come: it waits until somebody brings more."""
    elsewhere: tuple[str, ...]
    """Storages that have as much, the nearest first; at most three."""


def shortage_of(row: TransportRow, projection: Projection) -> Shortage | None:
    """What a transport waits for at its source.

    Args:
        row: the transport.
        projection: what storages and machines have told.

    Returns:
        None where somebody carries it, it is not to begin yet, it waits for something else, its source was never heard, or has enough.
    """
    if row.status is not TransportState.WAITING or row.wait not in ("", TransportWait.SHORT):
        return None
    here = _free(row.source, row.item, projection)
    if here is None or here[0] >= row.quantity:
        return None
    plant = projection.site.plant
    x_m, y_m = plant.position_of(row.destination)

    def rank(storage: str) -> tuple[float, str]:
        there_x_m, there_y_m = plant.position_of(storage)
        return hypot(there_x_m - x_m, there_y_m - y_m), storage

    elsewhere = [
        storage
        for storage in plant.keepers_of(row.item)
        if storage in plant.stores
        and storage not in (row.source, row.destination)
        and (has := _free(storage, row.item, projection)) is not None
        and has[0] >= row.quantity
    ]
    free, on_order = here
    return Shortage(free=free, on_order=on_order, elsewhere=tuple(sorted(elsewhere, key=rank)[:NAMED_MOST]))


def _free(place: str, item: str, projection: Projection) -> tuple[int, int] | None:
    """Pieces that are free at a place, and those that are to come there; None where it was not heard, or does not keep them."""
    station = projection.stations.view(place)
    for stock in station.stocks if station is not None else ():
        if stock.item == item:
            return max(0, stock.level - stock.promised), stock.on_order
    machine = projection.machines.view(place)
    for buffer in machine.buffers if machine is not None else ():
        if buffer.item == item:
            return buffer.level, buffer.on_order
    return None
