"""Seeded demand: the orders of one shift, as data.

Orders arrive as customers send them: at random moments, of random products and sizes. Their number follows from the
plant: `load` says which part of its machines' time they take.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from dray.messages import OrderItem
from dray.plant import Plant
from dray.priorities import Priority, order_wanted_s

LOAD = 0.6
"""The fraction of the machines' time that customers of a running plant order: lively, with room for a person's own orders."""

HEAD_START_S = 2000.0
"""Their demand begins as if it had run for this long: some six orders at once, so that a plant in real time is busy from its first
minute."""

FIRST_ORDER_S = 10.0
"""Agents have joined and heard of one another by then."""

MAX_LOTS_PER_ITEM = 3

MAX_PIECES = 10_000
"""Most pieces of one item: the limit of a gateway, for any lots of a plant."""

DUE_AFTER_S = (2700.0, 7200.0)
"""Between 45 minutes and two hours: same-day orders, which take some 20 minutes in a quiet plant."""


@dataclass(frozen=True, slots=True)
class Order:
    """One order of the demand.

    Attributes:
        at_s: when it is placed (plant clock).
        due_s: when all of it should be in the delivery warehouse (plant clock).
    """

    id: str
    at_s: float
    due_s: float
    items: tuple[OrderItem, ...]
    priority: Priority = Priority.NORMAL

    @property
    def wanted_s(self) -> float:
        """Time by which agents should deliver it (plant clock)."""
        return order_wanted_s(self.priority, self.at_s, self.due_s)


def orders(plant: Plant, random: Random, *, load: float, until_s: float, first: int = 1) -> Iterator[Order]:
    """Orders in the order of their times.

    Args:
        plant: its products and cycle times.
        random: the only source of chance.
        load: part of all machines' time that the orders take, above 0.
        until_s: no order is placed later (plant clock).
        first: number of the first order; ids are `D1`, `D2`, and so on.
    """
    products = plant.ordered
    now_s, number = FIRST_ORDER_S, first - 1
    while now_s < until_s:
        number += 1
        chosen = random.sample(products, k=min(random.choice((1, 1, 1, 2)), len(products)))
        items = tuple(_item(plant, random, product) for product in chosen)
        yield Order(f"D{number}", now_s, now_s + random.uniform(*DUE_AFTER_S), items)
        work_s = sum(item.quantity * mean_cycle_s(plant, item.product) for item in items)
        # Exponential gaps: an order knows nothing of the one before it.
        now_s += random.expovariate(1.0) * work_s / (len(plant.machines) * load)


def mean_cycle_s(plant: Plant, product: str) -> float:
    """Seconds of machine time for one piece with all its parts, over the machines that can make them."""
    cycles_s = [plant.cycle_s(machine, product) for machine in plant.machines_for(product)]
    parts = [line for line in plant.products[product].bill if line.material in plant.parts]
    parts_s = sum((line.quantity * mean_cycle_s(plant, line.material) for line in parts), start=0.0)
    return sum(cycles_s) / len(cycles_s) + parts_s


def _item(plant: Plant, random: Random, product: str) -> OrderItem:
    lot = min(plant.products[product].lot, MAX_PIECES)
    most = min(lot * MAX_LOTS_PER_ITEM, MAX_PIECES)
    return OrderItem(product=product, quantity=random.randint(lot, most))
