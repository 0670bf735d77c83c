"""The needs of an order before it is published: machines, material, and time. Pure.

The estimate follows the factory: every item is split among capable machines in whole containers. Each part
goes to the machine that would finish it first, after its own goals and unclaimed ones. The resulting promises
give a range as for running orders (`tracking.eta`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from math import ceil

import msgspec

from dray.gateway.live.views import MachineView, OrderView
from dray.gateway.tracking.eta import History, Running, eta, rounded
from dray.plant.model import MachineSpec, PlantFile, Product

ENDED = ("delivered", "cancelled", "stored")
"""Statuses of orders of which nothing is being made."""


class StorageShare(msgspec.Struct, frozen=True):
    """A storage that has a material."""

    storage: str
    capacity: int
    """Pieces when full; storages do not report their level."""


class MaterialNeed(msgspec.Struct, frozen=True, kw_only=True):
    """One material."""

    material: str
    needed: int
    """Pieces that this order needs."""
    loads: int
    """Containers to bring to machines for them."""
    wanted: int
    """Pieces that other open orders still need."""
    at_machines: int
    """Pieces in the buffers of machines that can make the products."""
    storages: tuple[StorageShare, ...]
    refills: bool
    """Whether the total need exceeds buffers and storages, so that the source must send more."""


class MachineOffer(msgspec.Struct, frozen=True, kw_only=True):
    """A machine that can make a part of it."""

    machine: str
    status: str
    """`silent` when the machine is not heard."""
    available: bool
    """False when silent or in error."""
    queue_s: float
    """Factory seconds of work before this order."""
    pieces: int
    """Pieces of this order that the estimate gives it."""


class OrderPreview(msgspec.Struct, frozen=True, kw_only=True):
    """The needs of an order if it were published now."""

    materials: tuple[MaterialNeed, ...]
    machines: tuple[MachineOffer, ...]
    cannot: tuple[str, ...]
    """Products that no machine can make now."""
    earliest_at_s: float | None
    """Earliest delivery, wall clock; null if unknown."""
    latest_at_s: float | None
    """Latest delivery, wall clock; null if unknown."""
    late: str
    """Lateness against the due time: empty, `maybe` or `yes`."""


class Wanted(msgspec.Struct, frozen=True):
    """Pieces of one product to make."""

    product: str
    quantity: int


class Situation(msgspec.Struct, frozen=True, kw_only=True):
    """The present state of the factory."""

    machines: Mapping[str, MachineView]
    """Machines that were heard, by id."""
    orders: Sequence[OrderView]
    history: History
    now_s: float
    """Wall clock."""
    heard_since_s: float
    """Machines last heard before this are silent."""
    speed: float
    """Factory seconds per real second."""


def preview(
    plant: PlantFile, wanted: Sequence[Wanted], due_at_s: float | None, situation: Situation
) -> OrderPreview:
    """The needs of these pieces.

    Args:
        plant: machines, products and bills of materials.
        wanted: known products.
        due_at_s: wall clock; None for no due time.
        situation: the present state.
    """
    shop = _Shop(plant, situation)
    for work in _unclaimed(situation):
        shop.take(work)
    before_s = dict(shop.queue_s)
    taken = [part for work in wanted for part in shop.take(work)]
    finish_s = [part.finish_s for part in taken]
    cannot = tuple(sorted({work.product for work in wanted if not shop.makers(work.product)}))
    expected = None
    if not cannot:
        promises = [situation.now_s + each_s / situation.speed for each_s in finish_s]
        expected = eta([Running(1, 0, at_s) for at_s in promises], situation.history, situation.now_s)
    shown = None if expected is None else rounded(expected)
    pieces: Counter[str] = Counter()
    for part in taken:
        pieces[part.machine] += part.quantity
    return OrderPreview(
        materials=_materials(plant, wanted, situation),
        machines=tuple(
            MachineOffer(
                machine=spec.id,
                status=shop.status(spec.id),
                available=shop.is_available(spec.id),
                queue_s=before_s[spec.id],
                pieces=pieces[spec.id],
            )
            for spec in plant.machines
            if any(_cycle_s(spec, work.product) is not None for work in wanted)
        ),
        cannot=cannot,
        earliest_at_s=None if shown is None else shown.from_s,
        latest_at_s=None if shown is None else shown.to_s,
        late="" if due_at_s is None or shown is None else _late(shown.from_s, shown.to_s, due_at_s),
    )


def _late(from_s: float, to_s: float, due_at_s: float) -> str:
    if from_s > due_at_s:
        return "yes"
    return "maybe" if to_s > due_at_s else ""


class _Part(msgspec.Struct, frozen=True):
    """Pieces that one machine would take."""

    machine: str
    quantity: int
    finish_s: float
    """Factory seconds from now."""


class _Shop:
    """The machines and their queues, which grow with all work taken."""

    def __init__(self, plant: PlantFile, situation: Situation) -> None:
        self._plant, self._situation = plant, situation
        self._products = {product.id: product for product in plant.products}
        self.queue_s = {spec.id: self._queue_s(spec) for spec in plant.machines}
        """Per machine, factory seconds of work before anything new."""

    def status(self, machine: str) -> str:
        view = self._situation.machines.get(machine)
        silent = view is None or view.seen_at_s < self._situation.heard_since_s
        return "silent" if silent or view is None else view.status

    def is_available(self, machine: str) -> bool:
        return self.status(machine) not in {"silent", "error"}

    def makers(self, product: str) -> list[tuple[str, float]]:
        """Machines that can make it now, and their cycle times (s)."""
        found = ((spec.id, _cycle_s(spec, product)) for spec in self._plant.machines)
        return [(machine, cycle_s) for machine, cycle_s in found if cycle_s and self.is_available(machine)]

    def take(self, work: Wanted) -> list[_Part]:
        """Share work out; empty when no machine can make it."""
        makers = self.makers(work.product)
        return [self._give(makers, quantity) for quantity in self._split(work, len(makers))]

    def _give(self, makers: Sequence[tuple[str, float]], quantity: int) -> _Part:
        """Give pieces to the machine that finishes first, since its bid would win."""
        finish_s, machine = min(
            (self.queue_s[machine] + quantity * cycle_s, machine) for machine, cycle_s in makers
        )
        self.queue_s[machine] = finish_s
        return _Part(machine, quantity, finish_s)

    def _split(self, work: Wanted, makers: int) -> list[int]:
        """Split work in whole containers, into at most as many parts as machines."""
        if not makers or not work.quantity:
            return []
        lot = self._products[work.product].lot
        share = ceil(ceil(work.quantity / lot) / makers) * lot
        whole, rest = divmod(work.quantity, share)
        return [share] * whole + ([rest] if rest else [])

    def _queue_s(self, spec: MachineSpec) -> float:
        view = self._situation.machines.get(spec.id)
        goals = () if view is None else view.goals
        return float(
            sum((goal.quantity - goal.made) * (_cycle_s(spec, goal.product) or 0.0) for goal in goals)
        )


def _cycle_s(spec: MachineSpec, product: str) -> float | None:
    return next((making.cycle_s for making in spec.makes if making.product == product), None)


def _to_make(orders: Iterable[OrderView]) -> Counter[str]:
    """Per product, the pieces that open orders still need."""
    pieces: Counter[str] = Counter()
    for order in orders:
        if order.status not in ENDED:
            for item in order.items:
                pieces[item.product] += item.quantity - item.made
    return pieces


def _unclaimed(situation: Situation) -> list[Wanted]:
    """Ordered work that no machine has taken yet: it comes before anything new."""
    pieces = _to_make(situation.orders)
    for view in situation.machines.values():
        for goal in view.goals:
            pieces[goal.product] -= goal.quantity - goal.made
    return [Wanted(product, quantity) for product, quantity in sorted(pieces.items()) if quantity > 0]


def _materials(plant: PlantFile, wanted: Sequence[Wanted], situation: Situation) -> tuple[MaterialNeed, ...]:
    products = {product.id: product for product in plant.products}
    makes = _levels(products, wanted)
    able = {spec.id for spec in plant.machines if makes & {making.product for making in spec.makes}}
    needed = _taken(products, wanted)
    others = _taken(products, (Wanted(*each) for each in _to_make(situation.orders).items()))
    return tuple(
        _need(plant, material.id, material.lot, needed[material.id], others[material.id], able, situation)
        for material in plant.materials
        if needed[material.id]
    )


def _need(
    plant: PlantFile,
    material: str,
    lot: int,
    needed: int,
    wanted: int,
    able: set[str],
    situation: Situation,
) -> MaterialNeed:
    at_machines = sum(
        buffer.level
        for view in situation.machines.values()
        if view.id in able
        for buffer in view.buffers
        if buffer.item == material
    )
    storages = tuple(
        StorageShare(storage.id, stock.capacity)
        for storage in plant.storages
        for stock in storage.stocks
        if stock.material == material
    )
    return MaterialNeed(
        material=material,
        needed=needed,
        loads=ceil(needed / lot),
        wanted=wanted,
        at_machines=at_machines,
        storages=storages,
        refills=needed + wanted > at_machines + sum(share.capacity for share in storages),
    )


def _taken(products: Mapping[str, Product], works: Iterable[Wanted]) -> Counter[str]:
    """Per material and part, the pieces that this work needs on all levels."""
    pieces: Counter[str] = Counter()
    ahead = list(works)
    while ahead:
        work = ahead.pop()
        product = products.get(work.product)
        for line in product.bill if product is not None else ():
            pieces[line.material] += line.quantity * work.quantity
            ahead.append(Wanted(line.material, line.quantity * work.quantity))
    return pieces


def _levels(products: Mapping[str, Product], wanted: Iterable[Wanted]) -> set[str]:
    """Products, and the parts on all levels below them."""
    found: set[str] = set()
    ahead = [work.product for work in wanted]
    while ahead:
        product = products.get(ahead.pop())
        if product is not None and product.id not in found:
            found.add(product.id)
            ahead += [line.material for line in product.bill]
    return found
