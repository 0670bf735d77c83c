"""Products that people define."""

from __future__ import annotations

from typing import Any

import httpx
from gateway_kit import House

NEW = {"If-None-Match": "*"}


def body(house: House, **changes: Any) -> dict[str, Any]:
    """A product of the first material, made at the first machine."""
    plant = house.projection.site.plant
    material, machine = next(iter(plant.materials)), next(iter(plant.machines))
    fields = {
        "name": "Bracket",
        "lot": 2,
        "ability": plant.abilities[0],
        "bill": {material: 2},
        "machines": {machine: 12.5},
    }
    return fields | changes


async def define(
    house: House, headers: dict[str, str], id_: str = "bracket", **changes: Any
) -> httpx.Response:
    return await house.client.put(f"/api/products/{id_}", json=body(house, **changes), headers=headers)
