"""Bills of several levels: the composition of a product, down to materials, and its faults.

A chain is named from a product to its parts: `drive <- gearbox <- shaft`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from dray.plant.file.reasons import Reason
from dray.plant.model import PlantFile, Product

CHAIN_MAX = 8
"""Most names of one chain that are shown."""


def level_faults(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Faults as (field, reason): products that are made of themselves, and machines that use their own products."""
    products = {product.id: product for product in file.products}
    told: set[frozenset[str]] = set()
    for index, product in enumerate(file.products):
        circle = circle_of(product.id, products)
        if circle and frozenset(circle) not in told:
            told.add(frozenset(circle))
            reason = Reason("plant_circle", item=circle[0], chain=chain_told(circle))
            yield f"products[{index}].bill", reason
    for index, machine in enumerate(file.machines):
        made = {making.product for making in machine.makes}
        for at, making in enumerate(machine.makes):
            bill = products[making.product].bill if making.product in products else ()
            own = next((line.material for line in bill if line.material in made), None)
            if own is not None:
                reason = Reason("plant_own_part", machine=machine.id, part=own, item=making.product)
                yield f"machines[{index}].makes[{at}].product", reason


def circle_of(product: str, products: Mapping[str, Product]) -> tuple[str, ...]:
    """The way from a product down to itself, both ends named; empty when there is none."""
    ways: list[tuple[str, ...]] = [(product,)]
    seen: set[str] = set()
    while ways:
        way = ways.pop()
        for line in products[way[-1]].bill:
            if line.material == product:
                return (*way, product)
            if line.material in products and line.material not in seen:
                seen.add(line.material)
                ways.append((*way, line.material))
    return ()


def made_into(file: PlantFile, item: str) -> str:
    """The products that need an item, to be added to a reason; empty when there is none."""
    way = [item]
    while (user := _user(file, way)) is not None:
        way.append(user)
    return Reason("needed_for", chain=chain_told(way[::-1])) if len(way) > 1 else ""


def chain_told(way: Sequence[str]) -> str:
    """A chain in words; of a long one its beginning and its end."""
    if len(way) > CHAIN_MAX:
        way = (*way[: CHAIN_MAX - 2], "...", way[-1])
    return " <- ".join(way)


def levels_of(file: PlantFile) -> int:
    """Number of levels of products; 1 where all are made of materials alone."""
    products = {product.id: product for product in file.products}
    heights: dict[str, int] = {}

    def height(product: str) -> int:
        if product not in heights:
            heights[product] = 0  # A circle ends here.
            below = [height(line.material) for line in products[product].bill if line.material in products]
            heights[product] = 1 + max(below, default=0)
        return heights[product]

    return max((height(product) for product in products), default=0)


def _user(file: PlantFile, way: Sequence[str]) -> str | None:
    for product in file.products:
        if product.id not in way and any(line.material == way[-1] for line in product.bill):
            return product.id
    return None
