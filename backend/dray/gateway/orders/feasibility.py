"""What an order would need, before it is published: machines, material, and time. Pure.

The estimate does what the factory will do: every item is split among the machines that can make it, in
whole containers, and each part goes to the machine that would be done with it first, after the goals that
it has and those that nobody has taken yet. From the promises that come of that, the range is made as for
orders that run (`tracking.eta`).
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
"""Orders of which nothing is being made."""


class StorageShare(msgspec.Struct, frozen=True):
    """A storage that has a material."""

    storage: str
    capacity: int
    """Pieces that it holds when it is full; storages do not tell how full they are."""


class MaterialNeed(msgspec.Struct, frozen=True, kw_only=True):
    """One material."""

    material: str
    needed: int
    """Pieces that this order takes."""
    loads: int
    """Containers that have to be brought to machines for them."""
    wanted: int
    """Pieces that other open orders still take."""
    at_machines: int
    """Pieces in the buffers of machines that can make the products."""
    storages: tuple[StorageShare, ...]
    refills: bool
    """Whether all of it together is more than buffers and storages hold: the source has to send more."""


class MachineOffer(msgspec.Struct, frozen=True, kw_only=True):
    """A machine that can make a part of it."""

    machine: str
    status: str
    """`silent` when nothing is heard of it."""
    available: bool
    """False for one that is silent or in error."""
    queue_s: float
    """Factory seconds of work that it has before."""
    pieces: int
    """Of this order, as this estimate shares it out."""


class OrderPreview(msgspec.Struct, frozen=True, kw_only=True):
    """What an order would need if it were published now."""

    materials: tuple[MaterialNeed, ...]
    machines: tuple[MachineOffer, ...]
    cannot: tuple[str, ...]
    """Products that no machine can make at this moment."""
    earliest_at_s: float | None
    """Wall clock. When it would be delivered: from here..."""
    latest_at_s: float | None
    """...to here; null when nothing can be said."""
    late: str
    """Against when it is due: empty, `maybe` or `yes`."""


class Wanted(msgspec.Struct, frozen=True):
    """Pieces of one product that somebody has to make."""

    product: str
    quantity: int


class Situation(msgspec.Struct, frozen=True, kw_only=True):
    """How things stand in the factory."""

    machines: Mapping[str, MachineView]
    """By id, those that were heard."""
    orders: Sequence[OrderView]
    history: History
    now_s: float
    """Wall clock."""
    heard_since_s: float
    """Who has not been heard since then is silent."""
    speed: float
    """Factory seconds per real second."""


def preview(
    plant: PlantFile, wanted: Sequence[Wanted], due_at_s: float | None, situation: Situation
) -> OrderPreview:
    """What these pieces would need.

    Args:
        plant: what can be made where, and of what.
        wanted: known products.
        due_at_s: wall clock; None for whenever.
        situation: how things stand.
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
    """The machines and their queues, which grow with everything that is taken."""

    def __init__(self, plant: PlantFile, situation: Situation) -> None:
        self._plant, self._situation = plant, situation
        self._products = {product.id: product for product in plant.products}
        self.queue_s = {spec.id: self._queue_s(spec) for spec in plant.machines}
        """By machine: factory seconds of work before anything new."""

    def status(self, machine: str) -> str:
        view = self._situation.machines.get(machine)
        silent = view is None or view.seen_at_s < self._situation.heard_since_s
        return "silent" if silent or view is None else view.status

    def is_available(self, machine: str) -> bool:
        return self.status(machine) not in {"silent", "error"}

    def makers(self, product: str) -> list[tuple[str, float]]:
        """Machines that can make it now, and their cycles (s)."""
        found = ((spec.id, _cycle_s(spec, product)) for spec in self._plant.machines)
        return [(machine, cycle_s) for machine, cycle_s in found if cycle_s and self.is_available(machine)]

    def take(self, work: Wanted) -> list[_Part]:
        """Share work out; empty when nobody can make it."""
        makers = self.makers(work.product)
        return [self._give(makers, quantity) for quantity in self._split(work, len(makers))]

    def _give(self, makers: Sequence[tuple[str, float]], quantity: int) -> _Part:
        """To the one that is done first, as its bid would win."""
        finish_s, machine = min(
            (self.queue_s[machine] + quantity * cycle_s, machine) for machine, cycle_s in makers
        )
        self.queue_s[machine] = finish_s
        return _Part(machine, quantity, finish_s)

    def _split(self, work: Wanted, makers: int) -> list[int]:
        """In whole containers, in as many parts as there are machines."""
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
    """By product: pieces that open orders still need."""
    pieces: Counter[str] = Counter()
    for order in orders:
        if order.status not in ENDED:
            for item in order.items:
                pieces[item.product] += item.quantity - item.made
    return pieces


def _unclaimed(situation: Situation) -> list[Wanted]:
    """What is ordered and no machine has taken yet: it comes before anything new."""
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
    """By material and part: pieces that this work takes, on all levels."""
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
