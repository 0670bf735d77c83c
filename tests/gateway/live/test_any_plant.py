"""A gateway of a plant that nobody here has drawn: it starts, and tells of it."""

from __future__ import annotations

import pytest
from gateway_kit import gateway
from plants import EXTREMES, plant_file
from variants import variants

from dray.plant import load_plant

PAGES = (
    "/api/plant",
    "/api/products",
    "/api/kpis",
    "/api/atvs",
    "/api/machines",
    "/api/traffic",
    "/api/inventory",
)


@pytest.mark.anyio
@pytest.mark.parametrize("kind", variants(EXTREMES, *list(EXTREMES)[::4]))
async def test_a_gateway_starts_in_it_and_takes_an_order(sqlite_url: str, kind: str) -> None:
    plant = plant_file(**EXTREMES[kind])
    async with gateway(sqlite_url, plant=plant) as house:
        house.bus.strategist()
        for page in PAGES:
            await house.get(page)
        items = [{"product": plant.products[0].id, "quantity": 2}]
        order = await house.place(items=items)
        ahead = await house.client.post("/api/orders/preview", json={"items": items})
        assert ahead.status_code == 200, ahead.text
        assert (await house.get(f"/api/orders/{order['id']}"))["id"] == order["id"]


@pytest.mark.anyio
async def test_panels_are_told_of_the_lanes_that_are_driven(sqlite_url: str) -> None:
    plant = load_plant("default")
    async with gateway(sqlite_url, plant=plant.file) as house:
        told = await house.get("/api/plant")
    assert [node["id"] for node in told["nodes"]] == list(plant.nodes)
    assert len(told["lanes"]) == len(plant.driven.lanes)
    assert not any(lane["two_lanes"] for lane in told["lanes"])
