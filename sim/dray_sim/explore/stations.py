"""A small plant whose material comes otherwise: storages that vehicles refill, and machines that fetch in the warehouse."""

from __future__ import annotations

from random import Random

from msgspec.structs import replace

from dray.plant import PlantFile, Stock, Storage, Warehouse
from dray_sim.plants.supplied import straight_from_the_warehouse

WAREHOUSE_LOTS = (2, 8)
"""Containers of a material in a source warehouse: few, so that it is empty at times and storages wait for it."""

STORAGE_LOTS = (1, 4)
"""Containers of a material in a storage that vehicles refill."""

STRAIGHT_FRAC = 0.25
"""Fraction of the plants in which storages keep parts alone, and machines fetch all else in the warehouse."""

DIRECT_FRAC = 0.4
"""Fraction of the warehouses beside storages in which machines fetch, too."""

REFILLED_FRAC = 0.8
"""Fraction of the storages that vehicles refill."""


def with_stations(file: PlantFile, random: Random) -> PlantFile:
    """The same plant with its material brought otherwise.

    Args:
        file: the plant; its own storages fill themselves.
        random: the only source of chance.
    """
    lots = {material.id: material.lot for material in file.materials}
    if random.random() < STRAIGHT_FRAC:
        file = straight_from_the_warehouse(file)
    else:
        storages = tuple(_refilled(storage, lots, random) for storage in file.storages)
        file = replace(file, storages=storages)
    return replace(file, warehouses=tuple(_stocked(each, lots, random) for each in file.warehouses))


def _refilled(storage: Storage, lots: dict[str, int], random: Random) -> Storage:
    if random.random() >= REFILLED_FRAC:
        return storage
    stocks = tuple(
        _ordered(kept, lots[kept.material], random) if kept.material in lots else kept
        for kept in storage.stocks
    )
    return replace(storage, refill="vehicles", stocks=stocks)


def _ordered(kept: Stock, whole: int, random: Random) -> Stock:
    """A stock with or without an explicit reorder point and lot."""
    capacity = random.randint(*STORAGE_LOTS) * whole + random.randint(0, whole)
    lot = random.randint(1, whole) if random.random() < 0.5 else None
    most = capacity - (whole if lot is None else lot)
    point = random.randint(0, most) if random.random() < 0.5 else None
    return Stock(kept.material, capacity, point, lot)


def _stocked(warehouse: Warehouse, lots: dict[str, int], random: Random) -> Warehouse:
    if warehouse.kind != "source":
        return warehouse
    stocks = tuple(Stock(item, random.randint(*WAREHOUSE_LOTS) * lot) for item, lot in lots.items())
    direct = warehouse.direct or random.random() < DIRECT_FRAC
    return replace(warehouse, stocks=stocks, direct=direct)
