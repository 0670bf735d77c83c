"""Products of the plant file in the form that goals carry; an order with its own definitions needs none of these."""

from __future__ import annotations

from collections.abc import Mapping

from dray.messages import BillLine, OrderItem, ProductDefinition
from dray.plant import Plant
from dray.plant.model import Product


def definition_for(item: OrderItem, plant: Plant) -> ProductDefinition | None:
    """The product definition of an order's item: the order's own, else the plant file's; None if neither has one."""
    product = plant.products.get(item.product)
    if item.definition is not None or product is None:
        return item.definition
    return definition_of(product)


def parts_of(definition: ProductDefinition, parts: Mapping[str, ProductDefinition], plant: Plant) -> set[str]:
    """The parts on all levels below a product, each once, even in a cycle."""
    found: set[str] = set()
    ahead = [definition]
    while ahead:
        for line in ahead.pop().bill:
            if line.material in plant.parts and line.material not in found:
                found.add(line.material)
                ahead.append(part_definition(line.material, parts, plant))
    return found


def part_definition(part: str, parts: Mapping[str, ProductDefinition], plant: Plant) -> ProductDefinition:
    """A part's definition: the order's own, else the plant file's."""
    return parts.get(part) or definition_of(plant.products[part])


def definition_of(product: Product) -> ProductDefinition:
    """A product of the plant file. Its machines know themselves that they make it."""
    return ProductDefinition(
        lot=product.lot,
        ability=product.ability,
        bill=tuple(BillLine(line.material, line.quantity) for line in product.bill),
        name=product.name,
    )
