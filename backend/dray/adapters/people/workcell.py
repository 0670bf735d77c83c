"""The body of a machine whose controller is people: what they say becomes reports.

    word                          is reported as                     is refused
    made N                        N times CycleDone                  unlikely: more than can have been made since the last
    scrapped N                    N times CycleDone, bad             likewise
    arrived N, a load waits       the difference to what was booked  unlikely: far from what was booked
    arrived N of V at the dock    nothing; V's load is booked as N   unlikely: far from what V was let in for
    arrived N of V, no such load  nothing                            no load: V has brought none that waits for a word
    arrived N, by hand            StockChanged by N                  unlikely: more than the buffer takes (no vehicle is named, and none
                                                                     stands there with it)
    taken N                       the same, out                      unlikely: more than lies there
    stock is N                    StockChanged by the difference     dock open: a vehicle is loading or unloading it; unlikely: far from what is believed

What is unlikely is taken when it is said to be sure. A word with a key that was heard before is answered as it was, and nothing else happens.

Nobody waits for people: what a vehicle says that it has brought or taken is booked at once, and shown until somebody confirms or corrects it. Every
word is remembered before it is reported, and reported before it is answered.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.vehicles_words import name_of, with_word
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
    StockChanged,
    Word,
    WordTaken,
    WorkcellState,
)
from dray.messages import (
    NOTHING_KNOWN,
    THING,
    CommandRefusal,
    MachineCommandKind,
    Problem,
    ProblemKind,
    UnconfirmedLoad,
)
from dray.messages.base import COUNT_MAX
from dray.plant import Plant
from dray.plant.model import MachineSpec
from dray.ports import Clock

PIECES_MAX = 100
"""Finished pieces in one word: each is a report of its own."""

FAR_FRAC, FAR_PIECES = 0.5, 5
"""A number is far from the expected one when it differs by more than this part of it, and by more than so many pieces."""

ROOM_FRAC, ROOM_PIECES = 1.5, 2
"""What can have been made in a time: so many times what the cycle allows, and a few more, since people say several at once."""

WORDS_KEPT = 1_000
"""Words that are known when they come again: more than all tablets of a machine have under way."""

LOADS_KEPT = 50
"""Loads that wait for a word. Of more the oldest are taken to be as their vehicles have said."""

_KIND = MachineCommandKind


class Answered(Struct, frozen=True, omit_defaults=True):
    """A word, and what became of it."""

    key: str
    refused: CommandRefusal | None = None
    detail: str = ""


class Visit(Struct, frozen=True, omit_defaults=True):
    """A vehicle at the dock, whose load is not booked yet."""

    vehicle: str
    item: str
    quantity: int
    said: int | None = None
    """What people say that it was; None while they have said nothing."""


class Taught(Struct, frozen=True):
    """A product as its orders say it is made."""

    bill: dict[str, int]
    """Material -> pieces."""
    cycle_s: float
    """0.0 for what the plant file says."""


class Kept(Struct, frozen=True):
    """What one life of an agent leaves to the next of a machine's body."""

    stock: dict[str, int]
    seq: int = 0
    cycling: str = ""
    last: str = ""
    """The product that was wanted last: pieces that nobody has asked for are taken for some of it."""
    made_s: float = 0.0
    """When somebody last said that a piece was finished, else when all began (plant clock)."""
    loads: tuple[UnconfirmedLoad, ...] = ()
    visits: tuple[Visit, ...] = ()
    answered: tuple[Answered, ...] = ()
    """The last words, the oldest first."""
    doubt: str = ""
    """Why counts may be wrong, until a person says that they were seen to."""
    taught: dict[str, Taught] = {}
    """Products that the plant file does not know, or knows with another bill of material."""
    booked: dict[str, tuple[int, int]] = {}
    """The latest words of vehicles (`dray.body.Book`), each with the change of the stock and its number: an agent that was killed says them again."""


DAMAGED = Kept({}, doubt="what was remembered of it is damaged: count what lies there")
"""What is known where a life has left something that cannot be read."""

_SOFTWARE = Problem(kind=ProblemKind.SOFTWARE, needs_person=True)


class World(Protocol):
    """What the body needs beside a clock."""

    def remember(self, kept: Kept) -> None:
        """Keep it: on the disk at the return."""


class PeopleWorkcell:
    """Implements `dray.ports.Body`.

    Args:
        spec: the machine.
        plant: for bills of material, and sizes of buffers.
        clock: the plant's.
        world: the disk.
        kept: what the last life has left; None for the first one, when nothing lies there until somebody has counted.
    """

    def __init__(
        self, spec: MachineSpec, plant: Plant, clock: Clock, world: World, kept: Kept | None = None
    ) -> None:
        self._clock, self._world = clock, world
        self._cycle_s = {making.product: making.cycle_s for making in spec.makes}
        self._bills = {
            product: {line.material: line.quantity for line in plant.products[product].bill}
            for product in self._cycle_s
        }
        materials = plant.materials_of(spec.id)
        self._room = {item: plant.materials[item].buffer for item in materials if item in plant.materials}
        items = dict.fromkeys((*materials, *self._cycle_s), 0)
        kept = kept or Kept(items, made_s=clock.now_s())
        self._kept = replace(kept, stock=items | kept.stock, last=kept.last or spec.makes[0].product)
        for product, taught in kept.taught.items():
            self._learn(product, taught)
        self._answers = {each.key: each for each in kept.answered}
        self._report: Callable[[Report], None] = _nobody_hears

    # --- Body ---

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. What people cannot do is ignored."""
        match instruction:
            case StartCycle():
                self._start(instruction)
            case OpenDock(vehicle=vehicle, item=item, quantity=quantity):
                self._let_in(Visit(vehicle, item, quantity))
            case CloseDock(vehicle=vehicle):
                self._let_out(vehicle)
            case Book():
                self._book(instruction)
            case ResetFault():
                self._reset()
            case Word():
                self._hear(instruction)
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
        )

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    # --- instructions ---

    def _start(self, start: StartCycle) -> None:
        product = start.product
        if start.bill:
            bill = {line.material: line.quantity for line in start.bill}
            taught = Taught(bill, max(0.0, start.cycle_s))
            if self._kept.taught.get(product) != taught:
                self._keep(taught=self._kept.taught | {product: taught})
                self._learn(product, taught)
        if reason := self._why_not(product):
            self._report(CycleFailed(product=product, reason=reason))
            return
        stock = self._kept.stock if self._kept.cycling else self._used(self._kept.stock, product)
        self._keep(stock=stock, cycling=product, last=product)

    def _learn(self, product: str, taught: Taught) -> None:
        self._bills[product] = taught.bill
        if taught.cycle_s > 0.0:
            self._cycle_s.setdefault(product, taught.cycle_s)

    def _why_not(self, product: str) -> str:
        """Why a piece cannot be begun; empty when it can."""
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

    def _let_in(self, visit: Visit) -> None:
        visits = self._kept.visits
        if all((each.vehicle, each.item) != (visit.vehicle, visit.item) for each in visits):
            others = tuple(each for each in visits if each.vehicle != visit.vehicle)
            self._keep(visits=(*others, visit))

    def _let_out(self, vehicle: str) -> None:
        visits = tuple(each for each in self._kept.visits if each.vehicle != vehicle)
        if visits != self._kept.visits:
            self._keep(visits=visits)

    def _book(self, book: Book) -> None:
        """A vehicle says what it has brought or taken: it is so until people say otherwise."""
        if name_of(book) not in self._kept.booked:
            self._take_in(book)
        change, seq = self._kept.booked[name_of(book)]
        self._report(StockChanged(item=book.item, change=change, seq=seq, vehicle=book.vehicle))

    def _take_in(self, book: Book) -> None:
        kept, change = self._kept, book.change
        visit = next((each for each in kept.visits if _is_of(each, book.vehicle, book.item)), None)
        loads = kept.loads
        if visit is not None and visit.said is not None:
            change = -visit.said if change < 0 else visit.said
        elif book.item != THING:
            load = UnconfirmedLoad(book.vehicle, book.item, abs(change), goes=change < 0)
            loads = (*loads, load)[-LOADS_KEPT:]
        stock, seq = self._moved(book.item, change), kept.seq + 1
        visits = tuple(each for each in kept.visits if each is not visit)
        booked = with_word(kept.booked, book, (change, seq))
        self._keep(stock=stock, seq=seq, loads=loads, visits=visits, booked=booked)

    def _reset(self) -> None:
        if self._kept.doubt:
            self._keep(doubt="")
            self._report(Repaired())

    # --- what people say ---

    def _hear(self, word: Word) -> None:
        before = self._answers.get(word.key)
        if before is not None:
            self._report(WordTaken(word.key, before.refused, before.detail, again=True))
            return
        refused, detail, reports, after = self._judge(word)
        answer = Answered(word.key, refused, detail)
        self._answers[word.key] = answer
        while len(self._answers) > WORDS_KEPT:
            del self._answers[next(iter(self._answers))]
        self._kept = replace(after, answered=tuple(self._answers.values()))
        self._world.remember(self._kept)
        for report in reports:
            self._report(report)
        self._report(WordTaken(word.key, refused, detail))

    def _judge(self, word: Word) -> tuple[CommandRefusal | None, str, list[Report], Kept]:
        """Why a word is not taken, with the expected number; what is to be reported of it, and what is known then."""
        kind, kept = word.kind, self._kept
        if kind in (_KIND.MADE, _KIND.SCRAPPED):
            return self._judge_pieces(word)
        if word.item not in kept.stock:
            return CommandRefusal.NOT_HANDLED, "", [], kept
        if not 0 <= word.quantity <= COUNT_MAX:
            return CommandRefusal.QUANTITY_OUT_OF_RANGE, "", [], kept
        if kind is _KIND.STOCK_IS:
            return self._judge_count(word)
        return self._judge_load(word)

    def _judge_pieces(self, word: Word) -> tuple[CommandRefusal | None, str, list[Report], Kept]:
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

    def _judge_count(self, word: Word) -> tuple[CommandRefusal | None, str, list[Report], Kept]:
        kept, item = self._kept, word.item
        if any(visit.item == item for visit in kept.visits):
            return CommandRefusal.DOCK_OPEN, "", [], kept
        believed = kept.stock[item]
        if not word.sure and _is_far(word.quantity, believed):
            return CommandRefusal.UNLIKELY, str(believed), [], kept
        # What is counted settles what vehicles have brought and taken before.
        loads = tuple(load for load in kept.loads if load.item != item)
        after = replace(kept, loads=loads)
        return None, "", *self._corrected(after, item, word.quantity - believed)

    def _judge_load(self, word: Word) -> tuple[CommandRefusal | None, str, list[Report], Kept]:
        kept, goes = self._kept, word.kind is _KIND.TAKEN
        for load in kept.loads:
            if load.goes is goes and _is_of(load, word.vehicle, word.item):
                return self._confirmed(word, load)
        # Who names no vehicle while one stands there means its load: material that it brings, products that it takes.
        is_its = goes is (word.item in self._cycle_s)
        for visit in kept.visits:
            vehicle = word.vehicle or (visit.vehicle if is_its else "")
            if _is_of(visit, vehicle, word.item) and visit.said is None:
                return self._said_early(word, visit)
        if word.vehicle:
            return CommandRefusal.NO_LOAD, "", [], kept
        if not word.quantity:
            return CommandRefusal.QUANTITY_OUT_OF_RANGE, "", [], kept
        there = kept.stock[word.item]
        most = there if goes else max(0, self._room.get(word.item, COUNT_MAX) - there)
        if word.quantity > most and not word.sure:
            return CommandRefusal.UNLIKELY, str(most), [], kept
        change = -min(word.quantity, there) if goes else word.quantity
        seq = kept.seq + 1
        report = StockChanged(item=word.item, change=change, seq=seq)
        return None, "", [report], replace(kept, stock=self._moved(word.item, change), seq=seq)

    def _confirmed(
        self, word: Word, load: UnconfirmedLoad
    ) -> tuple[CommandRefusal | None, str, list[Report], Kept]:
        """A load that is booked: it was so, or it was another number."""
        kept = self._kept
        if not word.sure and _is_far(word.quantity, load.quantity):
            return CommandRefusal.UNLIKELY, str(load.quantity), [], kept
        after = replace(kept, loads=tuple(each for each in kept.loads if each is not load))
        more = word.quantity - load.quantity
        return None, "", *self._corrected(after, load.item, -more if load.goes else more)

    def _said_early(self, word: Word, visit: Visit) -> tuple[CommandRefusal | None, str, list[Report], Kept]:
        """Of a vehicle at the dock: its load is booked by this when it says that it is done."""
        kept = self._kept
        if not word.sure and _is_far(word.quantity, visit.quantity):
            return CommandRefusal.UNLIKELY, str(visit.quantity), [], kept
        said = replace(visit, said=word.quantity)
        visits = tuple(said if each is visit else each for each in kept.visits)
        return None, "", [], replace(kept, visits=visits)

    # --- stock ---

    def _corrected(self, kept: Kept, item: str, change: int) -> tuple[list[Report], Kept]:
        """There is another number than was believed."""
        stock = self._moved(item, change)
        change = stock[item] - kept.stock[item]
        if not change:
            return [], kept
        report = StockChanged(item=item, change=change, seq=kept.seq + 1, counted=True)
        return [report], replace(kept, stock=stock, seq=report.seq)

    def _moved(self, item: str, change: int) -> dict[str, int]:
        stock = self._kept.stock
        if item == THING:
            return stock
        return stock | {item: min(max(stock.get(item, 0) + change, 0), COUNT_MAX)}

    def _used(self, stock: dict[str, int], product: str) -> dict[str, int]:
        """The material of one piece is used up."""
        bill = self._bills.get(product, {})
        return stock | {item: max(0, stock.get(item, 0) - pieces) for item, pieces in bill.items()}

    def _keep(self, **changes: object) -> None:
        self._kept = replace(self._kept, **changes)
        self._world.remember(self._kept)


def _is_of(load: UnconfirmedLoad | Visit, vehicle: str, item: str) -> bool:
    return (load.vehicle, load.item) == (vehicle, item)


def _is_far(said: int, expected: int) -> bool:
    return abs(said - expected) > max(FAR_PIECES, FAR_FRAC * expected)


def _nobody_hears(report: Report) -> None:
    """What a body reports before its agent listens; its state tells it all the same."""
