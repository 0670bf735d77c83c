"""Products of the plant file, as goals carry them; an order that brings definitions of its own needs none of these."""

from __future__ import annotations

from collections.abc import Mapping

from dray.messages import BillLine, OrderItem, ProductDefinition
from dray.plant import Plant
from dray.plant.model import Product


def definition_for(item: OrderItem, plant: Plant) -> ProductDefinition | None:
    """The product of an order's item: as the order has it, else as the plant file does; None when neither knows it."""
    product = plant.products.get(item.product)
    if item.definition is not None or product is None:
        return item.definition
    return definition_of(product)


def parts_of(definition: ProductDefinition, parts: Mapping[str, ProductDefinition], plant: Plant) -> set[str]:
    """Parts on all levels below a product; of one that is made of itself, each once."""
    found: set[str] = set()
    ahead = [definition]
    while ahead:
        for line in ahead.pop().bill:
            if line.material in plant.parts and line.material not in found:
                found.add(line.material)
                ahead.append(part_definition(line.material, parts, plant))
    return found


def part_definition(part: str, parts: Mapping[str, ProductDefinition], plant: Plant) -> ProductDefinition:
    """A part of the plant: as an order has brought it, else as the plant file has it."""
    return parts.get(part) or definition_of(plant.products[part])


def definition_of(product: Product) -> ProductDefinition:
    """A product of the plant file. Which machines make it they know themselves."""
    return ProductDefinition(
        lot=product.lot,
        ability=product.ability,
        bill=tuple(BillLine(line.material, line.quantity) for line in product.bill),
        name=product.name,
    )
