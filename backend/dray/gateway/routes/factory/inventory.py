"""Inventory: what is where, by the agents' reports; materials, by the plant file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Query

from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, list_of, page
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import ClockView, StationView
from dray.gateway.live.visibility import Visibility
from dray.gateway.routes.parameters import Visible
from dray.plant.model import Storage

router = APIRouter(tags=["factory"])


class InventoryLine(msgspec.Struct, frozen=True, kw_only=True):
    """Pieces of one item at one place, by its agent's last report."""

    item: str
    """Id of a material or product."""
    place: str
    """Id of a machine or vehicle."""
    kind: Literal["buffer", "goods", "on_board"]
    """Material before a machine, finished goods of a machine, or a vehicle's load."""
    quantity: int
    capacity: int | None = None
    """Pieces that fit there; null for a vehicle."""
    on_order: int = 0
    """Pieces on their way there."""
    spare: int = 0
    """Finished pieces that no order needs any more: the next goal of that product at this machine uses
    them."""
    seen_at_s: float
    """Wall clock time of the report."""


class StoredMaterial(msgspec.Struct, frozen=True):
    """A material in a storage, by its station's last report."""

    material: str
    capacity: int
    """Pieces that fit there."""
    level: int | None = None
    """Pieces there; null if its station was never heard."""
    promised: int | None = None
    """Pieces of these set aside for transports."""
    wanted: int | None = None
    """Pieces that machines request and that cannot be promised yet."""
    on_order: int | None = None
    """Pieces on order or on their way there."""


class StorageAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """An interim storage, or a source warehouse where vehicles fetch something."""

    id: str
    name: str
    node: str
    """Node where vehicles dock."""
    stocks: tuple[StoredMaterial, ...]
    seen_at_s: float | None = None
    """Wall clock time of its station's report; null if never heard."""
    clock: ClockView | None = None
    """Offset of its station's clock; null while unknown."""


class MaterialAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """A material, and how much of it agents report."""

    id: str
    name: str
    lot: int
    """Pieces in one container."""
    storages: tuple[str, ...]
    """Ids of the storages that hold it."""
    at_machines: int
    on_board: int
    on_order: int


@router.get(
    "/inventory", responses={200: list_of(InventoryLine, "Pieces, by item and place")}, response_class=Json
)
async def list_inventory(
    projection: Provided[Projection],
    visible: Visible,
    item: Annotated[str, Query(max_length=128, description="The id of a material or product")] = "",
    place: Annotated[str, Query(max_length=128, description="The id of a machine or vehicle")] = "",
    cursor: Cursor = None,
    limit: Limit = PAGE,
) -> Json:
    """Items at machines and on board of vehicles, in the caller's areas."""
    lines = [
        line
        for line in _lines(projection, visible)
        if (item or line.item) == line.item and (place or line.place) == line.place
    ]
    return page(sorted(lines, key=_place), _place, cursor, limit)


@router.get("/storages", responses={200: list_of(StorageAnswer, "Storages, by id")}, response_class=Json)
async def list_storages(
    projection: Provided[Projection], visible: Visible, cursor: Cursor = None, limit: Limit = PAGE
) -> Json:
    """Storages, and warehouses where vehicles fetch something, in the caller's areas.

    With stocks, promises, and pieces on order.
    """
    stations, plant = projection.stations, visible.plant()
    stocked = (warehouse.as_storage() for warehouse in plant.warehouses if warehouse.stocks)
    storages = sorted(
        (_storage(each, stations.view(each.id)) for each in (*plant.storages, *stocked)),
        key=lambda each: each.id,
    )
    return page(storages, lambda each: each.id, cursor, limit)


@router.get("/materials", responses={200: list_of(MaterialAnswer, "Materials, by id")}, response_class=Json)
async def list_materials(
    projection: Provided[Projection], visible: Visible, cursor: Cursor = None, limit: Limit = PAGE
) -> Json:
    """Materials that machines consume, and how much of them is in the caller's areas."""
    plant, lines = visible.plant(), tuple(_lines(projection, visible))
    materials = [
        MaterialAnswer(
            id=each.id,
            name=each.name,
            lot=each.lot,
            storages=tuple(
                storage.id
                for storage in plant.storages
                if any(stock.material == each.id for stock in storage.stocks)
            ),
            at_machines=sum(line.quantity for line in lines if (line.item, line.kind) == (each.id, "buffer")),
            on_board=sum(line.quantity for line in lines if (line.item, line.kind) == (each.id, "on_board")),
            on_order=sum(line.on_order for line in lines if line.item == each.id),
        )
        for each in sorted(plant.materials, key=lambda each: each.id)
    ]
    return page(materials, lambda each: each.id, cursor, limit)


def _lines(projection: Projection, visible: Visibility) -> Iterator[InventoryLine]:
    for machine in projection.machines.views():
        if visible.machine(machine) is None:
            continue
        for kind, levels in (("buffer", machine.buffers), ("goods", machine.goods)):
            for level in levels:
                yield InventoryLine(
                    item=level.item,
                    place=machine.id,
                    kind="buffer" if kind == "buffer" else "goods",
                    quantity=level.level,
                    capacity=level.capacity,
                    on_order=level.on_order,
                    spare=level.spare,
                    seen_at_s=machine.seen_at_s,
                )
    for atv in projection.atvs.views():
        if atv.load and visible.atv(atv) is not None:
            yield InventoryLine(
                item=atv.load,
                place=atv.id,
                kind="on_board",
                quantity=atv.load_quantity,
                seen_at_s=atv.seen_at_s,
            )


def _place(line: InventoryLine) -> str:
    return f"{line.item} {line.place} {line.kind}"


def _storage(storage: Storage, station: StationView | None) -> StorageAnswer:
    told = {} if station is None else {stock.item: stock for stock in station.stocks}
    stocks = tuple(
        StoredMaterial(stock.material, stock.capacity)
        if (kept := told.get(stock.material)) is None
        else StoredMaterial(
            stock.material, stock.capacity, kept.level, kept.promised, kept.wanted, kept.on_order
        )
        for stock in storage.stocks
    )
    return StorageAnswer(
        id=storage.id,
        name=storage.name,
        node=storage.node,
        stocks=stocks,
        seen_at_s=None if station is None else station.seen_at_s,
        clock=None if station is None else station.clock,
    )
