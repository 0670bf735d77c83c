"""The body of a storage's or a warehouse's station that is people: they say what has arrived, was taken, and lies there."""

from __future__ import annotations

from collections.abc import Callable

from msgspec.structs import replace

from dray.adapters.people.words import KeptStock, Words, World
from dray.body import Book, CloseDock, Instruction, OpenDock, Report, StorageState, Word
from dray.messages import MachineCommandKind
from dray.plant.model import Storage as StorageSpec

DAMAGED_STORE = KeptStock({})
"""What is known where a life has left something that cannot be read: nothing lies there until somebody has counted."""


class PeopleStore:
    """Implements `dray.ports.Body`.

    Args:
        spec: what is kept there.
        world: the disk.
        kept: what the last life has left; None for the first one, when nothing lies there until somebody has counted.
    """

    def __init__(self, spec: StorageSpec, world: World[KeptStock], kept: KeptStock | None = None) -> None:
        kept = kept or KeptStock({})
        stock = {line.material: 0 for line in spec.stocks} | kept.stock
        room = {line.material: line.capacity for line in spec.stocks}
        its = {MachineCommandKind.TAKEN}
        if spec.refill == "vehicles":
            its.add(MachineCommandKind.ARRIVED)
        self._words = Words(replace(kept, stock=stock), world, room, lambda kind, _item: kind in its)

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
                self._words.on_word(instruction)
            case _:
                return

    def sense(self) -> StorageState:
        """See `dray.ports.Body`."""
        kept = self._words.kept
        return StorageState(
            stock=dict(kept.stock),
            seq=kept.seq,
            opened=tuple(visit.vehicle for visit in kept.visits),
            counts=False,
            people=True,
            loads=kept.loads,
        )

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._words.report = report
