"""The body of a storage's or a warehouse's station that is people: they say what has arrived, was taken, and lies there."""

from __future__ import annotations

from collections.abc import Callable

from msgspec.structs import replace

from dray.adapters.people.words import Judged, KeptStock, Words, World
from dray.body import Book, CloseDock, Instruction, OpenDock, Report, StorageState, Word
from dray.messages import MachineCommandKind
from dray.plant.model import Storage as StorageSpec


class KeptStore(KeptStock, frozen=True):
    """What one life of the agent leaves to the next of a storage's body."""

    uncounted: tuple[str, ...] = ()
    """Materials of which nobody knows how many pieces lie there; `stock` says what has come since."""
    damaged: bool = False


DAMAGED_STORE = KeptStore({}, damaged=True)
"""What is known where a life has left something that cannot be read: all of it has to be counted."""


class PeopleStore:
    """Implements `dray.ports.Body`.

    Args:
        spec: what is kept there.
        world: the disk.
        kept: what the last life has left; None for the first one, when nothing lies there until somebody has counted.
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
        """See `dray.ports.Body`. What people are not told here is ignored: they see on the tablet what is short."""
        match instruction:
            case OpenDock():
                self._words.let_in(instruction)
            case CloseDock(vehicle=vehicle):
                self._words.let_out(vehicle)
            case Book():
                self._words.book(instruction)
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
        """As anywhere; the first count of what nobody knows is far from nothing that is believed."""
        uncounted = self._words.kept.uncounted
        if word.kind is not MachineCommandKind.STOCK_IS or word.item not in uncounted:
            return self._words.judge(word)
        refused, detail, reports, after = self._words.judge(replace(word, sure=True))
        if refused is None:
            after = replace(after, uncounted=tuple(each for each in uncounted if each != word.item))
        return refused, detail, reports, after
