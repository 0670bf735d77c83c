"""A machine's buffers: their levels, open orders, and the next order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

from dray.messages import THING, BufferLevel, Production, Transport
from dray.messages.base import COUNT_MAX
from dray.plant import Plant
from dray.protocol.machine.production import GoalBook
from dray.protocol.machine.replenishment import LeadTime, order_quantity, reorder_point, runs_out_at_s
from dray.protocol.transports.lead_time import first_lead_s


class Supply:
    """The materials of one machine.

    Args:
        machine: the machine's id.
        plant: storages, lots and buffer sizes.
        goals: the machine's goals.
    """

    def __init__(self, machine: str, plant: Plant, goals: GoalBook) -> None:
        self._machine = machine
        self._plant = plant
        self._goals = goals
        self._per_cycle = dict.fromkeys(plant.materials_of(machine), 0)
        """By material: the most that one cycle takes of it."""
        for making in plant.machines[machine].makes:
            for line in plant.products[making.product].bill:
                self._provide(line.material, line.quantity)
        self._lead: dict[str, LeadTime] = {}
        self._on_order: Counter[str] = Counter()
        self._levels: tuple[BufferLevel, ...] | None = None
        self.stock: dict[str, int] = {}
        """Pieces of every material and product; only this class changes it."""
        self._seq = 0
        """Number of the last change in `stock` (`dray.body.WorkcellState.seq`)."""

    @property
    def materials(self) -> Collection[str]:
        """Materials with a buffer: those of its plant file, and those of later goals."""
        return self._per_cycle.keys()

    # --- stock ---

    def take_count(self, stock: dict[str, int], seq: int) -> None:
        """Take the workcell's initial count, which includes all reports to earlier lives."""
        self.stock, self._seq, self._levels = dict(stock), seq, None
        for item in stock:
            # Products are reported as goods: a buffer for a part made here would count it twice.
            if not self._goals.products.is_goods(item):
                self._provide(item, 1)

    def sense(self, stock: dict[str, int], seq: int) -> bool:
        """Take the workcell's count, unless reports on later changes are still to come.

        Returns:
            True if it differs from the stock here.
        """
        if seq != self._seq or stock == self.stock:
            return False
        self.stock, self._levels = dict(stock), None
        return True

    def change(self, item: str, pieces: int, seq: int) -> bool:
        """Apply a reported change of pieces, negative for taken ones.

        Returns:
            False if the initial count already includes it.
        """
        if seq <= self._seq:
            return False
        self._seq = seq
        self._move(item, pieces)
        return True

    def use(self, item: str, pieces: int) -> None:
        """A cycle takes pieces out."""
        self._move(item, -pieces)

    def level(self, item: str) -> int:
        return self.stock.get(item, 0)

    def levels(self) -> tuple[BufferLevel, ...]:
        """Every material's buffer, for the heartbeat; computed only after a change."""
        if self._levels is None:
            self._levels = tuple(
                BufferLevel(
                    item=material,
                    level=self.level(material),
                    capacity=self._plant.materials[material].buffer,
                    reorder_point=self._reorder_point(material),
                    on_order=self._on_order[material],
                )
                for material in self.materials
            )
        return self._levels

    def room(self, material: str) -> int:
        """Pieces for which the buffer has room."""
        if material == THING:
            return COUNT_MAX
        return (
            self._plant.materials[material].buffer - self.level(material) if material in self.materials else 0
        )

    # --- orders ---

    def lacks_goods(self, item: str, quantity: int) -> bool:
        """Whether fewer pieces of a product that is made here lie here."""
        return self._goals.products.is_goods(item) and self.level(item) < quantity

    def next_order(self, cycling: str, now_s: float) -> tuple[Transport, float] | None:
        """The next order and its deadline (plant clock); None if all levels suffice.

        Args:
            cycling: the product of the running cycle; empty for none.
            now_s: the present time.
        """
        for material in self.materials:
            quantity = self._missing(material, cycling)
            if quantity:
                work = Transport(
                    item=material,
                    quantity=quantity,
                    sources=self._sources_of(material),
                    destination=self._machine,
                    ability=self._plant.materials[material].ability,
                )
                return work, self._needed_at_s(material, now_s)
        return None

    def latest_s(self, work: Transport, planned_s: float, now_s: float) -> float:
        """Deadline of a load that can be fetched only now (plant clock)."""
        return max(planned_s, now_s + self._lead_of(work.item).mean_s)

    def needs(self, material: str, cycling: str) -> bool:
        """Whether any goal still needs the material."""
        return self._goals.need(material, cycling) > 0

    def ordered(self, work: Transport) -> None:
        """A transport was announced."""
        if work.item == THING:
            return
        self._on_order[work.item] += work.quantity
        self._levels = None

    def settled(self, work: Transport, took_s: float | None) -> None:
        """An announced transport has ended; `took_s` is its lead time if it was delivered."""
        if work.item == THING:
            return
        self._on_order[work.item] -= work.quantity
        self._levels = None
        if took_s is not None:
            self._lead_of(work.item).note(took_s)

    def longest_lead_s(self, work: Production) -> float:
        """The longest lead time of a goal's materials (s)."""
        return max(self._lead_of(line.material).mean_s for line in work.definition.bill)

    def patience_s(self) -> float:
        """Time for a transport without urgency (s): twice the longest lead time."""
        return 2.0 * max(self._lead_of(material).mean_s for material in self.materials)

    def goals_changed(self) -> None:
        """Update the buffers and their reorder points after a change of goals."""
        self._levels = None
        for goal in self._goals:
            for line in goal.work.definition.bill:
                self._provide(line.material, line.quantity)

    def _provide(self, material: str, per_cycle: int) -> None:
        """Have a buffer for a material with this use per cycle."""
        self._per_cycle[material] = max(self._per_cycle.get(material, 0), per_cycle)

    def _lead_of(self, material: str) -> LeadTime:
        lead = self._lead.get(material)
        if lead is None:
            first_s = first_lead_s(self._plant, self._machine, self._plant.storages_of(material))
            lead = self._lead[material] = LeadTime(first_s)
        return lead

    def _move(self, item: str, pieces: int) -> None:
        if item == THING:
            return
        # A workcell may count wrongly: a level is kept between 0 and COUNT_MAX.
        self.stock[item] = min(max(self.stock.get(item, 0) + pieces, 0), COUNT_MAX)
        self._levels = None

    def _missing(self, material: str, cycling: str) -> int:
        need = self._goals.need(material, cycling)
        if not need:
            return 0
        spec = self._plant.materials[material]
        expected = self.level(material) + self._on_order[material]
        return order_quantity(
            level=self.level(material),
            on_order=self._on_order[material],
            need=need,
            point=self._reorder_point(material),
            # Only needed parts are ordered: surplus would keep them from others.
            lot=min(spec.lot, need - expected) if material in self._plant.parts else spec.lot,
            capacity=spec.buffer,
        )

    def _sources_of(self, material: str) -> tuple[str, ...]:
        """The storages of a material, and for a part also its makers."""
        makers = self._plant.machines_for(material) if material in self._plant.parts else ()
        return (*self._plant.storages_of(material), *makers)

    def surplus(self, part: str, cycling: str) -> int:
        """Pieces of a part in the buffer that no goal here takes."""
        return max(0, self.level(part) - self._goals.need(part, cycling))

    def _needed_at_s(self, material: str, now_s: float) -> float:
        expected = self.level(material) + self._on_order[material]
        use_per_s = self._goals.use_per_s(material)
        return max(
            runs_out_at_s(now_s, expected, use_per_s, self._goals.working_time),
            now_s + self._lead_of(material).mean_s,
        )

    def _reorder_point(self, material: str) -> int:
        spec, per_cycle = self._plant.materials[material], self._per_cycle[material]
        ceiling = max(per_cycle, spec.buffer - spec.lot)
        return reorder_point(
            self._goals.use_per_s(material), self._lead_of(material).mean_s, per_cycle, ceiling
        )
