"""The body of a people's storage or warehouse station: people report arrivals, removals and counts."""

from __future__ import annotations

from collections.abc import Callable

from msgspec.structs import replace

from dray.adapters.people.words import Judged, KeptStock, Words, World
from dray.body import Book, CloseDock, FillTo, Instruction, OpenDock, Report, StorageState, Word
from dray.messages import MachineCommandKind
from dray.plant.model import Storage as StorageSpec


class KeptStore(KeptStock, frozen=True):
    """A storage's memory for the agent's next life."""

    uncounted: tuple[str, ...] = ()
    """Materials with an unknown count; `stock` contains only their later changes."""
    damaged: bool = False


DAMAGED_STORE = KeptStore({}, damaged=True)
"""The memory after unreadable data: all materials must be counted."""


class PeopleStore:
    """Implements `dray.ports.Body`.

    Args:
        spec: the storage.
        world: the disk.
        kept: the last life's memory; None for the first one, when the stock is empty until somebody has counted.
    """

    def __init__(self, spec: StorageSpec, world: World[KeptStore], kept: KeptStore | None = None) -> None:
        kept = kept or KeptStore({})
        stock = {line.material: 0 for line in spec.stocks} | kept.stock
        room = {line.material: line.capacity for line in spec.stocks}
        its = {MachineCommandKind.TAKEN}
        if spec.refill == "vehicles":
            its.add(MachineCommandKind.ARRIVED)
        uncounted = tuple(stock) if kept.damaged else kept.uncounted
        kept = replace(kept, stock=stock, uncounted=uncounted, damaged=False)
        self._words = Words(kept, world, room, lambda kind, _item: kind in its)

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Unneeded instructions are ignored: the tablet shows people what is short."""
        match instruction:
            case OpenDock():
                self._words.let_in(instruction)
            case CloseDock(vehicle=vehicle):
                self._words.let_out(vehicle)
            case Book():
                self._words.book(instruction)
            case FillTo(item=item, quantity=quantity):
                self._words.limit(item, quantity)
            case Word():
                self._words.on_word(instruction, self._judge)
            case _:
                return

    def sense(self) -> StorageState:
        """See `dray.ports.Body`."""
        kept = self._words.kept
        return StorageState(
            stock=dict(kept.stock),
            seq=kept.seq,
            opened=self._words.opened,
            gone=self._words.gone,
            counts=False,
            people=True,
            loads=kept.loads,
            uncounted=kept.uncounted,
        )

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._words.report = report

    def _judge(self, word: Word) -> Judged[KeptStore]:
        """The verdict on a report; the first count of an uncounted material is always likely."""
        uncounted = self._words.kept.uncounted
        if word.kind is not MachineCommandKind.STOCK_IS or word.item not in uncounted:
            return self._words.judge(word)
        refused, detail, reports, after = self._words.judge(replace(word, sure=True))
        if refused is None:
            after = replace(after, uncounted=tuple(each for each in uncounted if each != word.item))
        return refused, detail, reports, after
