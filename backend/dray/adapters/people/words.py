"""People's reports about the stock of a machine or a storage: arrivals, removals and counts.

    word                          is reported as                     is refused
    arrived N, a load waits       the difference to what was booked  unlikely: far from what was booked
    arrived N of V at the dock    nothing; V's load is booked as N   unlikely: far from what V was let in for
    the same, V has no permission StockChanged by N; V's own later   the same, and as by hand
                                  report changes nothing
    arrived N of V, no such load  nothing                            no load: V has no load that waits for a report
    arrived N, by hand            StockChanged by N                  unlikely: more than there is room for beside loads on their way (no
                                                                     vehicle is named, and none stands there with it)
    taken N                       the same, out                      unlikely: more than lies there
    stock is N                    StockChanged by the difference     dock open: a vehicle is loading or unloading it, or has lost its
                                                                     permission and its load is not reported; unlikely: far from the booked stock

An unlikely number is accepted after confirmation. A repeated key gets the same answer and has no other effect.

Nobody waits for people: a vehicle's own report is booked at once, and shown until somebody confirms or corrects it. Every report is stored
before it is passed on, and passed on before it is answered.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, Protocol, TypeVar

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.vehicles_words import name_of, with_word
from dray.body import Book, OpenDock, Report, StockChanged, Word, WordTaken
from dray.messages import THING, CommandRefusal, MachineCommandKind, UnconfirmedLoad
from dray.messages.base import COUNT_MAX

FAR_FRAC, FAR_PIECES = 0.5, 5
"""The difference from the expected number above which a number is far: this fraction and these pieces, both."""

WORDS_KEPT = 1_000
"""Maximum reports whose repetition is recognised: more than all tablets of a place have under way."""

LOADS_KEPT = 50
"""Maximum loads that wait for confirmation. Beyond that the vehicles' reports of the oldest are accepted."""


class Answered(Struct, frozen=True, omit_defaults=True):
    """A report, and its answer."""

    key: str
    refused: CommandRefusal | None = None
    detail: str = ""


class Visit(Struct, frozen=True, omit_defaults=True):
    """A vehicle at the dock whose load is not booked yet."""

    vehicle: str
    item: str
    quantity: int
    said: int | None = None
    """The people's number; None before their report."""
    goes: bool | None = None
    """Whether people report a removal, not an arrival; None where that was not stored: then the vehicle's report decides."""
    shut: bool = False
    """Whether its permission has ended. Until it has left it may still report its load."""


class KeptStock(Struct, frozen=True):
    """A place's stock, as memory for the agent's next life."""

    stock: dict[str, int]
    seq: int = 0
    loads: tuple[UnconfirmedLoad, ...] = ()
    visits: tuple[Visit, ...] = ()
    answered: tuple[Answered, ...] = ()
    """Answers to the last reports, the oldest first."""
    booked: dict[str, tuple[int, int]] = {}
    """The vehicles' latest reports (`dray.body.Book`), each with the stock change and its number: a restarted agent repeats them."""


K = TypeVar("K", bound=KeptStock)
K_contra = TypeVar("K_contra", bound=Struct, contravariant=True)

Judged = tuple[CommandRefusal | None, str, list[Report], K]
"""The reason to refuse a report with the expected number, the reports to pass on, and the new memory."""


class World(Protocol[K_contra]):
    """The surroundings of a people's body, beside its clock."""

    def remember(self, kept: K_contra) -> None:
        """Store the memory: on the disk at the return."""


class AnsweredWords:
    """The last reports, by key: a repeated one gets the same answer.

    Args:
        kept: the last answers, the oldest first.
    """

    def __init__(self, kept: tuple[Answered, ...]) -> None:
        self._answers = {each.key: each for each in kept}

    def again(self, word: Word) -> WordTaken | None:
        """The answer to a repeated report; None for a new one."""
        before = self._answers.get(word.key)
        return None if before is None else WordTaken(word.key, before.refused, before.detail, again=True)

    def note(self, answer: Answered) -> tuple[Answered, ...]:
        """Add an answer; returns those kept."""
        self._answers[answer.key] = answer
        while len(self._answers) > WORDS_KEPT:
            del self._answers[next(iter(self._answers))]
        return tuple(self._answers.values())


class Words(Generic[K]):
    """Vehicles' and people's reports at one place.

    Args:
        kept: the last life's memory.
        world: the disk.
        room: maximum pieces by item.
        is_its: whether an item's report that names no vehicle means the load of the vehicle at the dock, by kind of report.

    Attributes:
        kept: the present memory; changed by `keep`.
        report: receives the reports.
    """

    def __init__(
        self,
        kept: K,
        world: World[K],
        room: Mapping[str, int],
        is_its: Callable[[MachineCommandKind, str], bool],
    ) -> None:
        self.kept, self._world = kept, world
        self._room, self._is_its = room, is_its
        self._fill_to: dict[str, int] = {}
        self._answers = AnsweredWords(kept.answered)
        self.report: Callable[[Report], None] = nobody_hears

    def keep(self, **changes: object) -> None:
        """Change the memory: on the disk at the return."""
        self.kept = replace(self.kept, **changes)
        self._world.remember(self.kept)

    # --- vehicles ---

    @property
    def opened(self) -> tuple[str, ...]:
        """Vehicles with permission at the dock."""
        return tuple(visit.vehicle for visit in self.kept.visits if not visit.shut)

    @property
    def gone(self) -> tuple[str, ...]:
        """Vehicles without permission whose own report is still expected."""
        return tuple(visit.vehicle for visit in self.kept.visits if visit.shut)

    def let_in(self, opened: OpenDock) -> None:
        """A vehicle gets permission at the dock; harmless when it has it."""
        visit = Visit(opened.vehicle, opened.item, opened.quantity)
        visits = self.kept.visits
        if all(each.shut or (each.vehicle, each.item) != (visit.vehicle, visit.item) for each in visits):
            others = tuple(each for each in visits if each.vehicle != visit.vehicle)
            self.keep(visits=(*others, visit))

    def let_out(self, vehicle: str) -> None:
        """End its permission: people's report of its load is kept for its own report. Repeated: it has left, and will report nothing."""
        visits = tuple(
            replace(each, shut=True) if each.vehicle == vehicle else each
            for each in self.kept.visits
            if each.vehicle != vehicle or not each.shut
        )
        if visits != self.kept.visits:
            self.keep(visits=visits)

    def book(self, book: Book) -> None:
        """Book a vehicle's own report of a transfer; people may correct it later."""
        by_hand = 0 if name_of(book) in self.kept.booked else self._take_in(book)
        change, seq = self.kept.booked[name_of(book)]
        self.report(StockChanged(item=book.item, change=change, seq=seq, vehicle=book.vehicle))
        if by_hand:
            self.report(StockChanged(item=book.item, change=by_hand, seq=seq + 1))

    def _take_in(self, book: Book) -> int:
        """Book it; returns the pieces moved by hand meanwhile."""
        kept, change = self.kept, book.change
        visit = next((each for each in kept.visits if _is_of(each, book.vehicle, book.item)), None)
        loads = kept.loads
        goes = change < 0 if visit is None or visit.goes is None else visit.goes
        said = 0 if visit is None or visit.said is None else -visit.said if goes else visit.said
        # A report of the other direction was not about this load.
        is_of_it = visit is not None and visit.said is not None and goes is (change < 0)
        by_hand = 0 if is_of_it else said
        if is_of_it:
            change = said
        elif book.item != THING:
            load = UnconfirmedLoad(book.vehicle, book.item, abs(change), goes=change < 0)
            loads = (*loads, load)[-LOADS_KEPT:]
        seq = kept.seq + 1
        stock, seqs = self.moved(book.item, change + by_hand), seq + bool(by_hand)
        visits = tuple(each for each in kept.visits if each is not visit)
        booked = with_word(kept.booked, book, (change, seq))
        self.keep(stock=stock, seq=seqs, loads=loads, visits=visits, booked=booked)
        return by_hand

    # --- people ---

    def on_word(self, word: Word, judge: Callable[[Word], Judged[K]] | None = None) -> None:
        """Accept a report, or refuse it with a reason.

        Args:
            word: the report.
            judge: its check; by default `judge`.
        """
        if (before := self._answers.again(word)) is not None:
            self.report(before)
            return
        refused, detail, reports, after = (judge or self.judge)(word)
        self.kept = replace(after, answered=self._answers.note(Answered(word.key, refused, detail)))
        self._world.remember(self.kept)
        for report in reports:
            self.report(report)
        self.report(WordTaken(word.key, refused, detail))

    def limit(self, item: str, pieces: int) -> None:
        """Expect people to bring an item by hand up to this many pieces only: the rest of the room is for vehicles."""
        self._fill_to[item] = pieces

    def judge(self, word: Word) -> Judged[K]:
        """The verdict on a report about the stock."""
        kept = self.kept
        if word.item not in kept.stock:
            return CommandRefusal.NOT_HANDLED, "", [], kept
        if not 0 <= word.quantity <= COUNT_MAX:
            return CommandRefusal.QUANTITY_OUT_OF_RANGE, "", [], kept
        if word.kind is MachineCommandKind.STOCK_IS:
            return self._judge_count(word)
        if word.kind in (MachineCommandKind.ARRIVED, MachineCommandKind.TAKEN):
            return self._judge_load(word)
        return CommandRefusal.NOT_SUPPORTED, "", [], kept

    def _judge_count(self, word: Word) -> Judged[K]:
        kept, item = self.kept, word.item
        if any(visit.item == item and (not visit.shut or visit.said is None) for visit in kept.visits):
            # It is unknown whether the count includes its load: its own report would count it again.
            return CommandRefusal.DOCK_OPEN, "", [], kept
        believed = kept.stock[item]
        if not word.sure and is_far(word.quantity, believed):
            return CommandRefusal.UNLIKELY, str(believed), [], kept
        # A count settles earlier transfers of vehicles, and early reports of loads that are not booked yet.
        loads = tuple(load for load in kept.loads if load.item != item)
        visits = tuple(
            replace(each, said=0, goes=None) if each.item == item else each for each in kept.visits
        )
        after = replace(kept, loads=loads, visits=visits)
        return None, "", *self._corrected(after, item, word.quantity - believed)

    def _judge_load(self, word: Word) -> Judged[K]:
        kept, goes = self.kept, word.kind is MachineCommandKind.TAKEN
        for load in kept.loads:
            if load.goes is goes and _is_of(load, word.vehicle, word.item):
                return self._confirmed(word, load)
        is_its = self._is_its(word.kind, word.item)
        # Vehicles at the dock come first: the report may not mean a vehicle that left long ago.
        for visit in sorted(kept.visits, key=lambda each: each.shut):
            vehicle = word.vehicle or (visit.vehicle if is_its else "")
            if not _is_of(visit, vehicle, word.item) or visit.said is not None:
                continue
            if word.vehicle or not visit.shut or not is_far(word.quantity, visit.quantity):
                return self._said_early(word, visit)
        if word.vehicle:
            return CommandRefusal.NO_LOAD, "", [], kept
        if not word.quantity:
            return CommandRefusal.QUANTITY_OUT_OF_RANGE, "", [], kept
        return self._by_hand(word)

    def _by_hand(self, word: Word) -> Judged[K]:
        """Book a report at once, as far as possible."""
        kept = self.kept
        there = kept.stock[word.item]
        goes = word.kind is MachineCommandKind.TAKEN
        room = self._room.get(word.item, COUNT_MAX)
        if not word.vehicle:
            room = min(room, self._fill_to.get(word.item, room))
        most = there if goes else max(0, room - there)
        if word.quantity > most and not word.sure:
            return CommandRefusal.UNLIKELY, str(most), [], kept
        change = -min(word.quantity, there) if goes else word.quantity
        seq = kept.seq + 1
        report = StockChanged(item=word.item, change=change, seq=seq)
        return None, "", [report], replace(kept, stock=self.moved(word.item, change), seq=seq)

    def _confirmed(self, word: Word, load: UnconfirmedLoad) -> Judged[K]:
        """Confirm or correct a booked load."""
        kept = self.kept
        if not word.sure and is_far(word.quantity, load.quantity):
            return CommandRefusal.UNLIKELY, str(load.quantity), [], kept
        after = replace(kept, loads=tuple(each for each in kept.loads if each is not load))
        more = word.quantity - load.quantity
        return None, "", *self._corrected(after, load.item, -more if load.goes else more)

    def _said_early(self, word: Word, visit: Visit) -> Judged[K]:
        """Keep people's number for a vehicle at the dock: its own report books it. If the vehicle may never report, book it at once."""
        if not word.sure and is_far(word.quantity, visit.quantity):
            return CommandRefusal.UNLIKELY, str(visit.quantity), [], self.kept
        refused, detail, reports, kept = self._by_hand(word) if visit.shut else (None, "", [], self.kept)
        if refused is not None:
            return refused, detail, reports, kept
        said = 0 if visit.shut else word.quantity
        goes = word.kind is MachineCommandKind.TAKEN
        now = replace(visit, said=said, goes=goes)
        visits = tuple(now if each is visit else each for each in kept.visits)
        return refused, detail, reports, replace(kept, visits=visits)

    # --- stock ---

    def _corrected(self, kept: K, item: str, change: int) -> tuple[list[Report], K]:
        """Correct the stock by a difference."""
        stock = self.moved(item, change)
        change = stock[item] - kept.stock[item]
        if not change:
            return [], kept
        report = StockChanged(item=item, change=change, seq=kept.seq + 1, counted=True)
        return [report], replace(kept, stock=stock, seq=report.seq)

    def moved(self, item: str, change: int) -> dict[str, int]:
        """The stock after a change; things without master data are not counted."""
        stock = self.kept.stock
        if item == THING:
            return stock
        return stock | {item: min(max(stock.get(item, 0) + change, 0), COUNT_MAX)}


def _is_of(load: UnconfirmedLoad | Visit, vehicle: str, item: str) -> bool:
    return (load.vehicle, load.item) == (vehicle, item)


def is_far(said: int, expected: int) -> bool:
    """Whether a number needs a confirmation."""
    return abs(said - expected) > max(FAR_PIECES, FAR_FRAC * expected)


def nobody_hears(report: Report) -> None:
    """Ignore a body's reports before its agent listens; its state contains them."""
