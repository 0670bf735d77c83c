"""The same plant with its material brought otherwise: storages that vehicles refill, or none, and all straight from the warehouse."""

from __future__ import annotations

from msgspec.structs import replace

from dray.plant import PlantFile, Stock

WAREHOUSE_LOTS = 200
"""Containers of each material that a source warehouse holds; more comes from outside before half of them are gone."""


def refilled_by_vehicles(file: PlantFile) -> PlantFile:
    """Storages order from the source warehouses, and vehicles bring it."""
    storages = tuple(replace(storage, refill="vehicles") for storage in file.storages)
    return replace(_stocked(file, direct=False), storages=storages)


def straight_from_the_warehouse(file: PlantFile) -> PlantFile:
    """Machines have material fetched in the source warehouses; storages keep parts alone."""
    parts = {product.id for product in file.products if product.buffer}
    kept = [
        replace(storage, stocks=tuple(stock for stock in storage.stocks if stock.material in parts))
        for storage in file.storages
    ]
    return replace(_stocked(file, direct=True), storages=tuple(storage for storage in kept if storage.stocks))


def _stocked(file: PlantFile, *, direct: bool) -> PlantFile:
    stocks = tuple(Stock(each.id, WAREHOUSE_LOTS * each.lot) for each in file.materials)
    warehouses = tuple(
        replace(each, stocks=stocks, direct=direct) if each.kind == "source" else each
        for each in file.warehouses
    )
    return replace(file, warehouses=warehouses)
