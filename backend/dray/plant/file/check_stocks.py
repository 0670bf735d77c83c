"""Faults of stocks in a plant file: the contents of storages and source warehouses, and their refills."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from dray.plant.file.reasons import Reason
from dray.plant.model import Material, PlantFile, Stock, Storage, Warehouse

Fault = tuple[str, str]
"""Field and reason."""


def stock_faults(file: PlantFile, materials: Sequence[Material]) -> Iterator[Fault]:
    """All of them.

    Args:
        file: the plant file.
        materials: those that come from outside, and parts.
    """
    lots = {material.id: material.lot for material in materials}
    for where, stock in stocks_of(file):
        lot = lots.get(stock.material, 0)
        if stock.capacity < lot:
            yield f"{where}.capacity", Reason("stock_small", count=stock.capacity, lot=lot)
    for index, storage in enumerate(file.storages):
        yield from once((stock.material for stock in storage.stocks), f"storages[{index}].stocks", "material")
    for index, warehouse in enumerate(file.warehouses):
        where = f"warehouses[{index}].stocks"
        yield from once((stock.material for stock in warehouse.stocks), where, "material")
    come = {material.id for material in file.materials}
    for index, warehouse in enumerate(file.warehouses):
        yield from _warehouse(warehouse, f"warehouses[{index}]", lots.keys() - come)
    supplied = {stock.material for each in file.warehouses if each.kind == "source" for stock in each.stocks}
    for index, storage in enumerate(file.storages):
        yield from _refill(storage, f"storages[{index}]", lots, come, supplied)


def stocks_of(file: PlantFile) -> Iterator[tuple[str, Stock]]:
    """The stocks of storages and warehouses, with their fields."""
    for index, storage in enumerate(file.storages):
        yield from ((f"storages[{index}].stocks[{at}]", stock) for at, stock in enumerate(storage.stocks))
    for index, warehouse in enumerate(file.warehouses):
        yield from ((f"warehouses[{index}].stocks[{at}]", stock) for at, stock in enumerate(warehouse.stocks))


def stored_for_machines(file: PlantFile) -> set[str]:
    """Items that machines can fetch: in storages, and in warehouses that give them to machines."""
    direct = [stock for warehouse in file.warehouses if warehouse.direct for stock in warehouse.stocks]
    return {stock.material for storage in file.storages for stock in storage.stocks} | {
        stock.material for stock in direct
    }


def once(names: Iterable[str], where: str, key: str) -> Iterator[Fault]:
    """Report names that occur twice within one list."""
    seen: set[str] = set()
    for at, name in enumerate(names):
        if name in seen:
            yield f"{where}[{at}].{key}", Reason("plant_twice", name=name)
        seen.add(name)


def _warehouse(warehouse: Warehouse, where: str, parts: Collection[str]) -> Iterator[Fault]:
    if warehouse.stocks and warehouse.kind != "source":
        yield f"{where}.stocks", Reason("delivery_stocks")
    if warehouse.direct and not warehouse.stocks:
        yield f"{where}.direct", Reason("direct_nothing", warehouse=warehouse.id)
    for at, stock in enumerate(warehouse.stocks):
        if stock.material in parts:
            yield f"{where}.stocks[{at}].material", Reason("part_in_warehouse", item=stock.material)
        yield from _unused(stock, f"{where}.stocks[{at}]")


def _refill(
    storage: Storage, where: str, lots: Mapping[str, int], come: set[str], supplied: set[str]
) -> Iterator[Fault]:
    for at, stock in enumerate(storage.stocks):
        field, item = f"{where}.stocks[{at}]", stock.material
        if storage.refill != "vehicles" or item not in come:
            yield from _unused(stock, field)
            continue
        whole = lots[item]
        lot = whole if stock.lot is None else stock.lot
        if item not in supplied:
            yield f"{field}.material", Reason("no_source_of", item=item)
        if lot > whole:
            yield f"{field}.lot", Reason("lot_large", lot=lot, most=whole)
        elif stock.reorder_point is not None and stock.reorder_point + lot > stock.capacity:
            most = max(0, stock.capacity - lot)
            reason = Reason(
                "reorder_high", point=stock.reorder_point, lot=lot, capacity=stock.capacity, most=most
            )
            yield f"{field}.reorder_point", reason


def _unused(stock: Stock, where: str) -> Iterator[Fault]:
    for name in ("reorder_point", "lot"):
        if getattr(stock, name) is not None:
            yield f"{where}.{name}", Reason("stock_unused")
