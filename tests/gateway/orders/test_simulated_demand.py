"""The simulated demand of `dray up` at a gateway: on the same database it goes on where it was."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import pytest
from fake_bus import PLANT
from gateway_kit import House, draft, gateway
from wall_clock import NOW_S, Wall

from dray.cli.simulation import customers
from dray.gateway.orders.drafts import OrderDraft
from dray.plant import Plant
from dray.store.orders.order_filter import EVERY_ORDER
from dray.store.orders.orders import Order
from dray_sim.people import demand

pytestmark = pytest.mark.anyio

SPEED, SEED = 10.0, 1


class EnoughError(Exception):
    """As many orders are open as a test wants."""


async def ordered(house: House, monkeypatch: pytest.MonkeyPatch, until: int) -> list[Order]:
    """Let the demand place orders until so many are open; all of its own that there are then, newest first."""

    async def wait(at_s: float, wall_s: Callable[[], float]) -> None:
        if house.projection.orders.open >= until:
            raise EnoughError
        house.wall.now_s = max(wall_s(), at_s)

    monkeypatch.setattr(customers, "wait_until", wait)
    with pytest.raises(EnoughError):
        await customers.place_demand(house.placement, Plant(PLANT), speed=SPEED, seed=SEED)
    async with house.store.read() as work:
        every = await work.orders.page(EVERY_ORDER, None, None)
    return [order for order in every if not order.caller]


def drawn(random: Random, first: int, count: int) -> list[tuple[str, tuple[tuple[str, int], ...]]]:
    """The demand itself: references, and what is ordered."""
    every = demand.orders(Plant(PLANT), random, load=demand.LOAD, until_s=1e9, first=first)
    some = [next(every) for _ in range(count)]
    return [(order.id, tuple((item.product, item.quantity) for item in order.items)) for order in some]


def told(orders: list[Order]) -> list[tuple[str, tuple[tuple[str, int], ...]]]:
    """The same of orders, by their numbers: several have come at one moment."""
    lines = [
        (order.reference or "", tuple((item.product, item.quantity) for item in order.items))
        for order in orders
    ]
    return sorted(lines, key=lambda line: int(line[0][1:]))


async def test_references_go_on_when_it_starts_anew_on_the_same_database(
    url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with gateway(url, speed=SPEED) as house:
        before = await ordered(house, monkeypatch, 11)
        # Somebody who gives the demand's name to orders does not move its count.
        await house.client.post(
            "/api/orders", json=draft(customer=customers.CUSTOMER, reference="D900", release=False)
        )
    assert told(before) == drawn(Random(f"{SEED} demand"), 1, 11)
    async with gateway(url, speed=SPEED, wall=Wall(NOW_S + 3600.0)) as house:
        after = await ordered(house, monkeypatch, house.projection.orders.open + 4)
    assert told(after)[-4:] == drawn(Random(f"{SEED} demand from 12"), 12, 4)
    references = [order.reference for order in after]
    assert len(references) == len(set(references)) == 15


async def test_what_is_no_number_of_the_demand_is_not_counted(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    others = ("D12b", "12", "D" + "9" * 50, "d7", None)
    for reference in others:
        body = draft(customer=customers.CUSTOMER, reference=reference)
        await house.placement.place(OrderDraft.model_validate(body))
    placed = await ordered(house, monkeypatch, len(others) + 2)
    assert {order.reference for order in placed} == {"D1", "D2", *others}
