"""The simulated customers of `dray up`: they place orders like any client, so that there is something to see."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable
from datetime import UTC, datetime
from random import Random

from dray.cli.runtime.gateway.service import Customers
from dray.gateway.http.problems import Problem
from dray.gateway.live.timescale import wait_until
from dray.gateway.orders.drafts import OrderDraft
from dray.gateway.orders.placement import OrderPlacement
from dray.plant import Plant
from dray_sim.people import demand

FIRST_S = 2.0
"""Wall seconds before the first orders: by then the agents know one another."""

FOREVER_S = float("inf")

MAX_OPEN = 40
"""Open orders above which customers wait. A plant that keeps up has some 15; the limit protects one with stopped
vehicles."""

CUSTOMER = "Simulated demand"

REFERENCE = re.compile(r"D([0-9]{1,18})")
"""The reference of an order of the demand, with its number."""

_log = logging.getLogger(__name__)


def customers_of(plant: Plant, *, speed: float, seed: int) -> Customers:
    """Customers who place orders at a gateway until cancelled.

    Args:
        plant: what can be ordered.
        speed: factory seconds per real second.
        seed: determines the orders and their times.
    """

    async def order(placement: OrderPlacement) -> None:
        await place_demand(placement, plant, speed=speed, seed=seed)

    return order


async def place_demand(placement: OrderPlacement, plant: Plant, *, speed: float, seed: int) -> None:
    """Place orders until cancelled. References continue after those in the database.

    Args:
        placement: places the orders.
        plant: what can be ordered.
        speed: factory seconds per real second.
        seed: determines the orders and their times, together with the first one's number.
    """
    began_s = placement.now_s + FIRST_S
    # Orders placed at one moment have no newest one, so as many are read as one moment may have.
    first = _number_after(await placement.newest_references(CUSTOMER, MAX_OPEN))
    random = Random(f"{seed} demand" if first == 1 else f"{seed} demand from {first}")
    for order in demand.orders(plant, random, load=demand.LOAD, until_s=FOREVER_S, first=first):
        at_s = max(0.0, order.at_s - demand.HEAD_START_S)
        await wait_until(began_s + at_s / speed, lambda: placement.now_s)
        if placement.open >= MAX_OPEN:
            continue
        due_s = placement.now_s + (order.due_s - order.at_s) / speed
        draft = OrderDraft.model_validate(
            {
                "customer": CUSTOMER,
                "reference": order.id,
                "items": [{"product": item.product, "quantity": item.quantity} for item in order.items],
                "due_at": datetime.fromtimestamp(due_s, UTC).isoformat(),
            }
        )
        try:
            await placement.place(draft)
        except Problem as problem:
            # A refused customer returns with the next order.
            _log.warning("simulated order %s was refused: %s", order.id, problem)


def _number_after(references: Iterable[str]) -> int:
    found = filter(None, map(REFERENCE.fullmatch, references))
    return max((int(each[1]) for each in found), default=0) + 1
