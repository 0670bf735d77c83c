"""What is short at a waiting transport's source, and which storages have enough, by their last heartbeats."""

from __future__ import annotations

from math import hypot

import msgspec

from dray.gateway.access.principal import Principal, Scope
from dray.gateway.live.projection import Projection
from dray.messages import TransportState, TransportWait
from dray.store.orders.transports import TransportRow

NAMED_MOST = 3
"""Maximum storages named: the nearest."""


class Shortage(msgspec.Struct, frozen=True, kw_only=True):
    """Why a transport cannot be fetched yet: its source is short."""

    free: int
    """Pieces at its source that are not set aside for others."""
    on_order: int
    """Pieces on order there. A storage that refills itself orders none."""
    elsewhere: tuple[str, ...]
    """Storages with enough, nearest first; at most three."""


def shortage_of(
    row: TransportRow, projection: Projection, caller: Principal, places: frozenset[str] | None
) -> Shortage | None:
    """The shortage that a transport waits for at its source.

    Args:
        row: the transport.
        projection: the storages' reports.
        caller: the caller.
        places: places that the caller sees; None for all.

    Returns:
        None if it is carried, held, or waits for something else; if its source is a machine (which does not
        report its promises), was never heard, or has enough; or if the caller may not see stocks there.
    """
    if not caller.may(Scope.FACTORY_READ) or (places is not None and row.source not in places):
        return None
    if row.status is not TransportState.WAITING or row.wait not in ("", TransportWait.SHORT):
        return None
    here = _free(row.source, row.item, projection)
    if here is None or here[0] >= row.quantity:
        return None
    plant = projection.site.plant
    if not plant.has_place(row.destination) or row.item not in plant.materials:
        return None
    x_m, y_m = plant.position_of(row.destination)

    def rank(storage: str) -> tuple[float, str]:
        there_x_m, there_y_m = plant.position_of(storage)
        return hypot(there_x_m - x_m, there_y_m - y_m), storage

    elsewhere = [
        storage
        for storage in plant.keepers_of(row.item)
        if storage in plant.stores
        and (places is None or storage in places)
        and storage not in (row.source, row.destination)
        and (has := _free(storage, row.item, projection)) is not None
        and has[0] >= row.quantity
    ]
    free, on_order = here
    return Shortage(free=free, on_order=on_order, elsewhere=tuple(sorted(elsewhere, key=rank)[:NAMED_MOST]))


def _free(place: str, item: str, projection: Projection) -> tuple[int, int] | None:
    """Free pieces at a storage, and pieces on order there.

    None if it was not heard or does not keep the item.
    """
    station = projection.stations.view(place)
    for stock in station.stocks if station is not None else ():
        if stock.item == item:
            return max(0, stock.level - stock.promised), stock.on_order
    return None
