"""Goals with their definitions."""

from __future__ import annotations

from dray.messages import BillLine, ProductDefinition, Production
from dray.plant import Plant
from dray.protocol.strategist.definitions import definition_of

ANY = ProductDefinition(lot=24, ability="tote", bill=(BillLine("shaft", 1),), name="Any product")
"""For tests to which it does not matter of what something is made."""


def making(
    product: str, quantity: int, order: str = "O1", item: int = 0, plant: Plant | None = None
) -> Production:
    """So many pieces of a product for an order: as a plant file has it, or of whatever it may be."""
    known = None if plant is None else plant.products.get(product)
    definition = ANY if known is None else definition_of(known)
    return Production(product, quantity, order, item, definition)
