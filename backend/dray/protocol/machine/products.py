"""What a machine can make: what it was set up for, and what goals tell of other products."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from dray.memory import ProductMemory
from dray.messages import THING, ProductDefinition, Production
from dray.plant import Plant
from dray.protocol.runtime.bounded_map import BoundedMap

BROUGHT_KEPT = 1000
"""Products that goals have brought: more than lie in the goods of one machine."""


class Products:
    """The products of one machine.

    A goal in work brings its own definition; what is kept here is for pieces that belong to no goal.

    Args:
        machine: its id in the plant.
        plant: what it was set up for, and the materials that can be had.

    Attributes:
        own: the products that it was set up for.
    """

    def __init__(self, machine: str, plant: Plant) -> None:
        self._machine = machine
        self._plant = plant
        self._cycle_s = {making.product: making.cycle_s for making in plant.machines[machine].makes}
        self.own = tuple(self._cycle_s)
        self._brought: BoundedMap[str, ProductDefinition] = BoundedMap(BROUGHT_KEPT)
        self._known = self.own

    def __iter__(self) -> Iterator[str]:
        """All that it knows: its own, then those that goals have brought."""
        return iter(self._known)

    def note(self, product: str, definition: ProductDefinition) -> None:
        """Goals bring definitions; the last one counts for pieces that belong to none."""
        self._brought[product] = definition
        self._known = (*self.own, *(name for name in self._brought if name not in self._cycle_s))

    def restore(self, memory: Sequence[ProductMemory]) -> None:
        """Know what an earlier life was brought; before pieces are counted, for what is made here lies in no buffer."""
        for known in memory:
            self.note(known.product, known.definition)

    def container(self, product: str) -> tuple[int, str]:
        """Pieces in a container, and what a vehicle must be able to carry, of a product that it knows."""
        known = self._brought.get(product) or self._plant.products[product]
        return known.lot, known.ability

    def is_goods(self, item: str) -> bool:
        """Whether something is made here, rather than used."""
        return item in self._cycle_s or item in self._brought or item not in (THING, *self._plant.materials)

    def parts(self) -> tuple[str, ...]:
        """What it makes of which others make something."""
        return tuple(product for product in self if product in self._plant.parts)

    def can_make(self, work: Production) -> bool:
        """Whether it was set up for the product of a goal, or the goal names it."""
        return work.product in self._cycle_s or self._told_s(work) is not None

    def can_make_by_itself(self, product: str) -> bool:
        """Whether it was set up for a product."""
        return product in self._cycle_s

    def objection(self, work: Production) -> str:
        """Why it can never make a goal's product, in words; empty when it can."""
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
        """Seconds for one piece at full speed: the machine's own word, else the goal's.

        Raises:
            KeyError: neither says it; see `can_make`.
        """
        told_s = self._cycle_s.get(work.product, self._told_s(work))
        if told_s is None:
            raise KeyError(work.product)
        return told_s

    def memories(self, level: Callable[[str], int]) -> tuple[ProductMemory, ...]:
        """What the next life must know of pieces that lie here and that it was not set up for."""
        return tuple(
            ProductMemory(product, definition)
            for product, definition in self._brought.items()
            if product not in self._cycle_s and level(product)
        )

    def _told_s(self, work: Production) -> float | None:
        named = (each.cycle_s for each in work.definition.machines if each.machine == self._machine)
        return next(named, None)


def per_piece(work: Production, material: str) -> int:
    """Pieces of a material that one piece of a goal takes."""
    return sum(line.quantity for line in work.definition.bill if line.material == material)


def at_hand(work: Production, stock: Mapping[str, int]) -> bool:
    """Whether all lies there that one piece of a goal takes."""
    return all(stock.get(line.material, 0) >= line.quantity for line in work.definition.bill)
