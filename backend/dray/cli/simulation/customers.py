"""The simulated customers of `dray up`: they order as anybody does, so that there is something to see."""

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

LOAD = 0.6
"""Part of the machines' time that the demand takes: lively, with room for a person's own orders."""

HEAD_START_S = 2000.0
"""The demand begins as if it had run for this long: some six orders at once, so that a plant in real
time is busy from its first minute."""

FIRST_S = 2.0
"""Wall seconds before the first orders: the agents have heard of one another by then."""

FOREVER_S = float("inf")

MAX_OPEN = 40
"""Open orders at which customers wait. A plant that keeps up has some 15; one in which somebody has
stopped the vehicles must not drown in orders."""

CUSTOMER = "Simulated demand"

REFERENCE = re.compile(r"D([0-9]{1,18})")
"""Of an order of the demand, with its number."""

_log = logging.getLogger(__name__)


def customers_of(plant: Plant, *, speed: float, seed: int) -> Customers:
    """Customers who place orders at a gateway until cancelled.

    Args:
        plant: what can be ordered.
        speed: factory seconds per real second.
        seed: the same orders at the same times follow from it.
    """

    async def order(placement: OrderPlacement) -> None:
        await place_demand(placement, plant, speed=speed, seed=seed)

    return order


async def place_demand(placement: OrderPlacement, plant: Plant, *, speed: float, seed: int) -> None:
    """Place orders until cancelled. References go on after those that the database has.

    Args:
        placement: where to.
        plant: what can be ordered.
        speed: factory seconds per real second.
        seed: the same orders at the same times follow from it, and from the number of the first one.
    """
    began_s = placement.now_s + FIRST_S
    # So many may have been placed at one moment, of which none is the newest.
    first = _number_after(await placement.newest_references(CUSTOMER, MAX_OPEN))
    random = Random(f"{seed} demand" if first == 1 else f"{seed} demand from {first}")
    for order in demand.orders(plant, random, load=LOAD, until_s=FOREVER_S, first=first):
        at_s = max(0.0, order.at_s - HEAD_START_S)
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
            # A customer who is refused comes back with the next order.
            _log.warning("simulated order %s was refused: %s", order.id, problem)


def _number_after(references: Iterable[str]) -> int:
    found = filter(None, map(REFERENCE.fullmatch, references))
    return max((int(each[1]) for each in found), default=0) + 1
