"""The body of a machine operated by people: their reports become the body's reports.

    word                          is reported as                     is refused
    made N                        N times CycleDone                  unlikely: more than possible since the last report
    scrapped N                    N times CycleDone, bad             likewise
    any other                     arrivals, removals, counts: see `words`

An unlikely number is accepted after confirmation.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from msgspec import Struct, field
from msgspec.structs import replace

from dray.adapters.people.words import Judged, KeptStock, Words, World
from dray.body import (
    Book,
    CloseDock,
    CycleDone,
    CycleFailed,
    Instruction,
    OpenDock,
    Repaired,
    Report,
    ResetFault,
    StartCycle,
    Word,
    WorkcellState,
)
from dray.messages import NOTHING_KNOWN, CommandRefusal, MachineCommandKind, Problem, ProblemKind
from dray.messages.base import COUNT_MAX
from dray.plant import Plant
from dray.plant.model import MachineSpec
from dray.ports import Clock

PIECES_MAX = 100
"""Maximum finished pieces in one report: each causes its own `CycleDone`."""

ROOM_FRAC, ROOM_PIECES = 1.5, 2
"""Maximum pieces in a time: this factor times the cycle's rate, plus a few, since people report several at once."""

_KIND = MachineCommandKind


class Taught(Struct, frozen=True):
    """A product's production data, as its orders define them."""

    bill: dict[str, int]
    """Material -> pieces."""
    cycle_s: float
    """Seconds per piece; 0.0 for the plant file's value."""


class Kept(KeptStock, frozen=True):
    """A machine's memory for the agent's next life."""

    cycling: str = ""
    last: str = ""
    """The product last asked for: pieces made without an instruction count as this."""
    made_s: float = 0.0
    """The time of the last report of a finished piece, or of the start (plant clock)."""
    doubt: str = ""
    """Why counts may be wrong, until a person has checked them."""
    taught: dict[str, Taught] = field(default_factory=dict)
    """Products that the plant file lacks, or defines with another bill of material."""


DAMAGED = Kept({}, doubt="what was remembered of it is damaged: count what lies there")
"""The memory after unreadable data."""

_SOFTWARE = Problem(kind=ProblemKind.SOFTWARE, needs_person=True)


class PeopleWorkcell:
    """Implements `dray.ports.Body`.

    Args:
        spec: the machine.
        plant: for bills of material, and sizes of buffers.
        clock: the plant's.
        world: the disk.
        kept: the last life's memory; None for the first one, when the stock is empty until somebody has counted.
    """

    def __init__(
        self, spec: MachineSpec, plant: Plant, clock: Clock, world: World[Kept], kept: Kept | None = None
    ) -> None:
        self._clock = clock
        self._cycle_s = {making.product: making.cycle_s for making in spec.makes}
        self._bills = {
            product: {line.material: line.quantity for line in plant.products[product].bill}
            for product in self._cycle_s
        }
        materials = plant.materials_of(spec.id)
        room = {item: plant.materials[item].buffer for item in materials if item in plant.materials}
        items = dict.fromkeys((*materials, *self._cycle_s), 0)
        kept = kept or Kept(items, made_s=clock.now_s())
        kept = replace(kept, stock=items | kept.stock, last=kept.last or spec.makes[0].product)
        # Vehicles bring material, and take products.
        self._words = Words(
            kept, world, room, lambda kind, item: (kind is _KIND.TAKEN) is (item in self._cycle_s)
        )
        for product, taught in kept.taught.items():
            self._learn(product, taught)

    # --- Body ---

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Instructions that people cannot follow are ignored."""
        match instruction:
            case StartCycle():
                self._start(instruction)
            case OpenDock():
                self._words.let_in(instruction)
            case CloseDock(vehicle=vehicle):
                self._words.let_out(vehicle)
            case Book():
                self._words.book(instruction)
            case ResetFault():
                self._reset()
            case Word():
                self._words.on_word(instruction, self._judge)
            case _:
                return

    def sense(self) -> WorkcellState:
        """See `dray.ports.Body`."""
        kept = self._kept
        return WorkcellState(
            stock=dict(kept.stock),
            seq=kept.seq,
            cycling=kept.cycling,
            broken=kept.doubt,
            counts=False,
            about_problem=_SOFTWARE if kept.doubt else NOTHING_KNOWN,
            resettable=bool(kept.doubt),
            people=True,
            loads=kept.loads,
            opened=self._words.opened,
            gone=self._words.gone,
        )

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._words.report = report

    # --- instructions ---

    @property
    def _kept(self) -> Kept:
        return self._words.kept

    def _start(self, start: StartCycle) -> None:
        product = start.product
        if start.bill:
            bill = {line.material: line.quantity for line in start.bill}
            taught = Taught(bill, max(0.0, start.cycle_s))
            if self._kept.taught.get(product) != taught:
                self._words.keep(taught=self._kept.taught | {product: taught})
                self._learn(product, taught)
        if reason := self._why_not(product):
            self._words.report(CycleFailed(product=product, reason=reason))
            return
        stock = self._kept.stock if self._kept.cycling else self._used(self._kept.stock, product)
        self._words.keep(stock=stock, cycling=product, last=product)

    def _learn(self, product: str, taught: Taught) -> None:
        self._bills[product] = taught.bill
        if taught.cycle_s > 0.0:
            self._cycle_s.setdefault(product, taught.cycle_s)

    def _why_not(self, product: str) -> str:
        """The reason why a piece cannot be begun; empty for none."""
        kept = self._kept
        if product not in self._cycle_s:
            return "not made here"
        if kept.doubt:
            return kept.doubt
        if kept.cycling:
            return "" if kept.cycling == product else f"busy with {kept.cycling}"
        bill = self._bills.get(product, {})
        missing = [item for item, pieces in bill.items() if kept.stock.get(item, 0) < pieces]
        return f"missing {', '.join(missing)}" if missing else ""

    def _reset(self) -> None:
        if self._kept.doubt:
            self._words.keep(doubt="")
            self._words.report(Repaired())

    # --- what people say ---

    def _judge(self, word: Word) -> Judged[Kept]:
        if word.kind in (_KIND.MADE, _KIND.SCRAPPED):
            return self._judge_pieces(word)
        return self._words.judge(word)

    def _judge_pieces(self, word: Word) -> Judged[Kept]:
        kept, now_s = self._kept, self._clock.now_s()
        product = word.item or kept.cycling or kept.last
        if product not in self._cycle_s:
            return CommandRefusal.NOT_HANDLED, "", [], kept
        if not 0 < word.quantity <= PIECES_MAX:
            return CommandRefusal.QUANTITY_OUT_OF_RANGE, "", [], kept
        span_s = max(0.0, now_s - kept.made_s)
        most = ROOM_PIECES + math.ceil(ROOM_FRAC * span_s / self._cycle_s[product])
        if word.quantity > most and not word.sure:
            return CommandRefusal.UNLIKELY, str(most), [], kept
        reports: list[Report] = []
        stock, cycling, seq, bad = dict(kept.stock), kept.cycling, kept.seq, word.kind is _KIND.SCRAPPED
        for _ in range(word.quantity):
            if cycling == product:
                cycling = ""  # Its material is used already.
            else:
                stock = self._used(stock, product)
            if not bad:
                stock[product] = min(stock.get(product, 0) + 1, COUNT_MAX)
            seq += 1
            reports.append(CycleDone(product=product, seq=seq, bad=bad))
        return None, "", reports, replace(kept, stock=stock, cycling=cycling, seq=seq, made_s=now_s)

    def _used(self, stock: dict[str, int], product: str) -> dict[str, int]:
        """The stock without the material of one piece."""
        bill = self._bills.get(product, {})
        return stock | {item: max(0, stock.get(item, 0) - pieces) for item, pieces in bill.items()}
