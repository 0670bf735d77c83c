"""A small plant with bills of several levels, machines that make bad pieces, and orders with priorities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import TypeVar

import msgspec

from dray.plant import BillLine, MachineSpec, Making, PlantFile, Product, Stock, Storage
from dray.priorities import Priority
from dray_sim.people import demand

Thing = TypeVar("Thing")

LEVELS_MAX = 3

QUANTITY_MAX = 2
"""Most pieces of one part in a piece of the next level; larger bills would only cause more transports."""

LOTS_KEPT = (2, 6)
"""Containers of a part for which a storage has room."""

BUFFER_LOTS = 3
"""Containers that the buffer of a part holds, as of materials in small plants."""

SCRAP_FRAC = (0.02, 0.25)
"""Fraction of cycles with a bad piece: large, because runs are short."""

SCRAPPING_FRAC = 0.6
"""Fraction of the products with any bad pieces."""


def with_levels(file: PlantFile, random: Random) -> PlantFile:
    """The same plant with parts: machines of one level make parts for those of the next one.

    Args:
        file: with two machines and two products at least.
        random: the only source of chance.
    """
    count = min(random.randint(2, LEVELS_MAX), len(file.machines), len(file.products))
    products = _dealt(file.products, count, random)
    machines = _dealt(file.machines, count, random)
    cycle_s = {making.product: making.cycle_s for spec in file.machines for making in spec.makes}
    levels = _chained(products, random)
    made = {product.id: product for level in levels for product in level}
    makes = {
        spec.id: makings
        for tier, level in zip(machines, levels, strict=True)
        for spec, makings in _making(tier, level, cycle_s, random)
    }
    parts = [product for product in made.values() if product.buffer]
    return msgspec.structs.replace(
        file,
        products=tuple(made[product.id] for product in file.products),
        machines=tuple(msgspec.structs.replace(spec, makes=makes[spec.id]) for spec in file.machines),
        storages=_keeping(file.storages, parts, random),
    )


def with_scrap(file: PlantFile, random: Random) -> PlantFile:
    """The same plant, some of whose machines end some cycles with a bad piece."""

    def scrapping(making: Making) -> Making:
        frac = random.uniform(*SCRAP_FRAC) if random.random() < SCRAPPING_FRAC else 0.0
        return msgspec.structs.replace(making, scrap_frac=round(frac, 2))

    return msgspec.structs.replace(
        file,
        machines=tuple(
            msgspec.structs.replace(spec, makes=tuple(map(scrapping, spec.makes))) for spec in file.machines
        ),
    )


def with_priorities(orders: Sequence[demand.Order], random: Random) -> tuple[demand.Order, ...]:
    """The same orders, each wanted as soon as somebody says."""
    return tuple(replace(order, priority=random.choice(tuple(Priority))) for order in orders)


def _dealt(things: Sequence[Thing], count: int, random: Random) -> list[list[Thing]]:
    """Into so many heaps, none of them empty."""
    mixed = random.sample(things, len(things))
    heaps = [[thing] for thing in mixed[:count]]
    for thing in mixed[count:]:
        random.choice(heaps).append(thing)
    return heaps


def _chained(levels: list[list[Product]], random: Random) -> list[list[Product]]:
    """Add bills: each product takes parts of the level below, and perhaps of one further down; each part is taken."""
    chained = [levels[0]]
    for level in levels[1:]:
        below, further = chained[-1], [part for lower in chained[:-1] for part in lower]
        taken: list[list[Product]] = [[random.choice(below)] for _ in level]
        for part in below:
            if not any(part in parts for parts in taken):
                random.choice(taken).append(part)
        for parts in taken:
            if further and random.random() < 0.5:
                parts.append(random.choice(further))
        chained.append([_of(product, parts, random) for product, parts in zip(level, taken, strict=True)])
    buffered = [[_buffered(part) for part in level] for level in chained[:-1]]
    return [*buffered, chained[-1]]


def _of(product: Product, parts: Sequence[Product], random: Random) -> Product:
    """Made of parts, and of some of its materials."""
    kept = random.sample(product.bill, random.randint(0, min(2, len(product.bill))))
    lines = (BillLine(part.id, random.randint(1, QUANTITY_MAX)) for part in parts)
    return msgspec.structs.replace(product, bill=(*lines, *kept))


def _buffered(part: Product) -> Product:
    return msgspec.structs.replace(part, buffer=BUFFER_LOTS * part.lot)


def _making(
    machines: Sequence[MachineSpec], products: Sequence[Product], cycle_s: dict[str, float], random: Random
) -> list[tuple[MachineSpec, tuple[Making, ...]]]:
    """Products of each machine of a level; at least one machine makes each product."""
    dealt: list[list[Product]] = [[random.choice(products)] for _ in machines]
    for product in products:
        if not any(product in heap for heap in dealt):
            random.choice(dealt).append(product)
    return [
        (spec, tuple(Making(product.id, cycle_s[product.id]) for product in heap))
        for spec, heap in zip(machines, dealt, strict=True)
    ]


def _keeping(storages: Sequence[Storage], parts: Sequence[Product], random: Random) -> tuple[Storage, ...]:
    """Keep each part in one storage or in two."""
    kept: dict[str, list[Stock]] = {storage.id: list(storage.stocks) for storage in storages}
    for part in parts:
        for storage in random.sample(list(kept), min(random.randint(1, 2), len(kept))):
            kept[storage].append(Stock(part.id, random.randint(*LOTS_KEPT) * part.lot))
    return tuple(msgspec.structs.replace(storage, stocks=tuple(kept[storage.id])) for storage in storages)
