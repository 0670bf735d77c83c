"""The products that a machine can make: its own, and those defined by goals."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from dray.memory import ProductMemory
from dray.messages import THING, ProductDefinition, Production
from dray.plant import Plant
from dray.protocol.runtime.bounded_map import BoundedMap

BROUGHT_KEPT = 1000
"""Maximum products defined by goals: more than lie in the goods of one machine."""


class Products:
    """The products of one machine.

    A goal has its own definition; those kept here are for pieces without a goal.

    Args:
        machine: its id in the plant.
        plant: the plant with the machine's products, and available materials.

    Attributes:
        own: the products of its plant file.
    """

    def __init__(self, machine: str, plant: Plant) -> None:
        self._machine = machine
        self._plant = plant
        self._cycle_s = {making.product: making.cycle_s for making in plant.machines[machine].makes}
        self.own = tuple(self._cycle_s)
        self._brought: BoundedMap[str, ProductDefinition] = BoundedMap(BROUGHT_KEPT)
        self._known = self.own

    def __iter__(self) -> Iterator[str]:
        """All known products: its own, then those defined by goals."""
        return iter(self._known)

    def note(self, product: str, definition: ProductDefinition) -> None:
        """Keep a goal's definition; the last one counts for pieces without a goal."""
        self._brought[product] = definition
        self._known = (*self.own, *(name for name in self._brought if name not in self._cycle_s))

    def restore(self, memory: Sequence[ProductMemory]) -> None:
        """Restore an earlier life's definitions, before the stock is counted, because products have no buffer."""
        for known in memory:
            self.note(known.product, known.definition)

    def container(self, product: str) -> tuple[int, str]:
        """Pieces per container and required ability of a known product."""
        known = self._brought.get(product) or self._plant.products[product]
        return known.lot, known.ability

    def is_goods(self, item: str) -> bool:
        """Whether an item is made here, not used."""
        return item in self._cycle_s or item in self._brought or item not in (THING, *self._plant.materials)

    def parts(self) -> tuple[str, ...]:
        """Products from which others make something."""
        return tuple(product for product in self if product in self._plant.parts)

    def can_make(self, work: Production) -> bool:
        """Whether the product is its own, or the goal names this machine."""
        return work.product in self._cycle_s or self._told_s(work) is not None

    def can_make_by_itself(self, product: str) -> bool:
        """Whether a product is its own."""
        return product in self._cycle_s

    def objection(self, work: Production) -> str:
        """Why it can never make a goal's product, in words; empty if it can."""
        if work.product in self._plant.materials and work.product not in self._plant.parts:
            return f"{work.product} is a material"
        if work.product in self._plant.materials_of(self._machine):
            return f"uses {work.product} itself"
        listed: set[str] = set()
        for line in work.definition.bill:
            material = self._plant.materials.get(line.material)
            if material is None:
                return f"no material {line.material}"
            if self.can_make_by_itself(line.material):
                return f"makes {line.material} itself"
            if not self._plant.storages_of(line.material):
                return f"no storage holds {line.material}"
            if line.quantity > material.buffer:
                return f"{line.quantity} {line.material} do not fit into a buffer of {material.buffer}"
            if line.material in listed:
                return f"{line.material} is listed twice"
            listed.add(line.material)
        return ""

    def cycle_s(self, work: Production) -> float:
        """Cycle time at full speed (s): the machine's own, else the goal's.

        Raises:
            KeyError: if neither is known; see `can_make`.
        """
        told_s = self._cycle_s.get(work.product, self._told_s(work))
        if told_s is None:
            raise KeyError(work.product)
        return told_s

    def memories(self, level: Callable[[str], int]) -> tuple[ProductMemory, ...]:
        """Definitions for the next life, of pieces that lie here and are not its own products."""
        return tuple(
            ProductMemory(product, definition)
            for product, definition in self._brought.items()
            if product not in self._cycle_s and level(product)
        )

    def _told_s(self, work: Production) -> float | None:
        named = (each.cycle_s for each in work.definition.machines if each.machine == self._machine)
        return next(named, None)


def per_piece(work: Production, material: str) -> int:
    """Pieces of a material per piece of a goal."""
    return sum(line.quantity for line in work.definition.bill if line.material == material)


def at_hand(work: Production, stock: Mapping[str, int]) -> bool:
    """Whether all material for one piece of a goal is in stock."""
    return all(stock.get(line.material, 0) >= line.quantity for line in work.definition.bill)
