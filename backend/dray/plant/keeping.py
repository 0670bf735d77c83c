"""The keepers of items: storages and source warehouses, and the source of each one's supplies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from dray.plant.model import PlantFile, Storage


class Keeping:
    """The keepers of one plant file.

    Args:
        file: the plant file.
        materials: external items, and parts.

    Attributes:
        stores: places with a station, by id: storages, and the source warehouses where something is fetched, each as
            a storage.
        places: material -> those that keep it.
        for_machines: material -> those of them where machines fetch it.
        supplies: material -> the source warehouses that have it, from which storages are refilled.
    """

    def __init__(self, file: PlantFile, materials: Iterable[str]) -> None:
        stocked = [warehouse for warehouse in file.warehouses if warehouse.stocks]
        stores = (*file.storages, *(warehouse.as_storage() for warehouse in stocked))
        self.stores: Mapping[str, Storage] = MappingProxyType({store.id: store for store in stores})
        self.places: Mapping[str, tuple[str, ...]] = {
            material: tuple(s.id for s in stores if any(kept.material == material for kept in s.stocks))
            for material in materials
        }
        others = {warehouse.id for warehouse in stocked if not warehouse.direct}
        self.for_machines = {
            material: tuple(place for place in places if place not in others)
            for material, places in self.places.items()
        }
        warehouses = {warehouse.id for warehouse in stocked}
        self.supplies = {
            material: tuple(place for place in places if place in warehouses)
            for material, places in self.places.items()
        }
