"""What people say at a storage ends in the right count: a vehicle's word is booked at once, and theirs corrects it, over lives of its agent."""

from __future__ import annotations

from itertools import count

import pytest
from msgspec.structs import replace

from dray.adapters.people.store import DAMAGED_STORE, KeptStore, PeopleStore
from dray.body import Book, CloseDock, FillTo, OpenDock, Report, StockChanged, Word, WordTaken
from dray.messages import CommandRefusal, MachineCommandKind, UnconfirmedLoad
from dray.plant import default_plant

KIND, REFUSED = MachineCommandKind, CommandRefusal
SPEC = next(iter(default_plant().storages.values()))
ITEM = SPEC.stocks[0].material
ROOM = SPEC.stocks[0].capacity
ATV = "ATV3"


class Shelf:
    """A storage whose disk outlives its agent."""

    def __init__(self, pieces: int = 40, *, refilled_by_vehicles: bool = False) -> None:
        self.spec = replace(SPEC, refill="vehicles") if refilled_by_vehicles else SPEC
        self.kept: KeptStore | None = None
        self.reports: list[Report] = []
        self._names = count(1)
        self.begin()
        self.says(KIND.STOCK_IS, pieces, sure=True)
        self.reports.clear()

    def begin(self) -> None:
        self.body = PeopleStore(self.spec, self, self.kept)
        self.body.attach(self.reports.append)

    def remember(self, kept: KeptStore) -> None:
        self.kept = kept

    def says(
        self, kind: MachineCommandKind, pieces: int, vehicle: str = "", *, sure: bool = False, key: str = ""
    ) -> tuple[CommandRefusal | None, str]:
        self.body.instruct(Word(key or f"maria/{next(self._names)}", kind, ITEM, pieces, vehicle, sure))
        taken = self.reports[-1]
        assert isinstance(taken, WordTaken)
        return taken.refused, taken.detail

    @property
    def level(self) -> int:
        return self.body.sense().stock[ITEM]

    def moved(self) -> list[int]:
        return [each.change for each in self.reports if isinstance(each, StockChanged)]


def fetched(shelf: Shelf, pieces: int = 12) -> None:
    """A vehicle is let in, and says what it has taken."""
    shelf.body.instruct(OpenDock(ATV, ITEM, pieces))
    shelf.body.instruct(Book(ATV, ITEM, -pieces, task="M1-1", epoch=1))


def test_nothing_lies_there_until_somebody_has_counted() -> None:
    shelf = PeopleStore(SPEC, Shelf())
    assert set(shelf.sense().stock.values()) == {0}
    assert shelf.sense().people


def test_what_a_vehicle_takes_is_booked_at_once_and_people_correct_it() -> None:
    shelf = Shelf()
    fetched(shelf)
    assert (shelf.level, shelf.body.sense().loads) == (28, (UnconfirmedLoad(ATV, ITEM, 12, goes=True),))
    assert shelf.says(KIND.TAKEN, 10, ATV) == (None, "")
    assert (shelf.level, shelf.body.sense().loads, shelf.moved()) == (30, (), [-12, 2])


def test_a_vehicles_word_that_its_agent_says_again_after_a_kill_is_booked_once() -> None:
    shelf = Shelf()
    fetched(shelf)
    shelf.begin()
    shelf.body.instruct(Book(ATV, ITEM, -12, task="M1-1", epoch=1))
    assert shelf.level == 28


def test_a_word_that_comes_again_counts_once_in_any_life() -> None:
    shelf = Shelf()
    for _ in range(3):
        assert shelf.says(KIND.ARRIVED, 12, key="maria/w1") == (None, "")
        shelf.begin()
    assert shelf.level == 52
    assert [each.again for each in shelf.reports if isinstance(each, WordTaken)] == [False, True, True]


@pytest.mark.parametrize(
    ("kind", "pieces", "expected"),
    [(KIND.TAKEN, 41, "40"), (KIND.ARRIVED, ROOM, str(ROOM - 40)), (KIND.STOCK_IS, 4, "40")],
)
def test_a_number_far_off_is_asked_once(kind: MachineCommandKind, pieces: int, expected: str) -> None:
    shelf = Shelf()
    assert shelf.says(kind, pieces) == (REFUSED.UNLIKELY, expected)
    assert shelf.level == 40
    assert shelf.says(kind, pieces, sure=True) == (None, "")
    assert shelf.level == {KIND.TAKEN: 0, KIND.ARRIVED: 40 + ROOM, KIND.STOCK_IS: 4}[kind]


def test_what_people_bring_leaves_room_for_loads_on_their_way() -> None:
    shelf = Shelf()
    shelf.body.instruct(FillTo(ITEM, 60))
    assert shelf.says(KIND.ARRIVED, 21) == (REFUSED.UNLIKELY, "20")
    assert shelf.says(KIND.ARRIVED, 20) == (None, "")
    shelf.body.instruct(Book(ATV, ITEM, 12, task="S1-1", epoch=1))
    assert shelf.level == 72, "the load on its way finds the room"
    shelf.body.instruct(FillTo(ITEM, ROOM))
    assert shelf.says(KIND.ARRIVED, 20) == (None, "")


def test_who_names_no_vehicle_means_the_one_that_stands_there_and_takes() -> None:
    shelf = Shelf()
    shelf.body.instruct(OpenDock(ATV, ITEM, 12))
    assert shelf.body.sense().opened == (ATV,)
    assert shelf.says(KIND.STOCK_IS, 40) == (REFUSED.DOCK_OPEN, "")
    assert shelf.says(KIND.TAKEN, 11) == (None, "")
    assert shelf.level == 40
    shelf.body.instruct(Book(ATV, ITEM, -12, task="M1-1", epoch=1))
    assert (shelf.level, shelf.body.sense().opened) == (29, ())


def by_hand(shelf: Shelf) -> int:
    """What 20 pieces that arrive while a vehicle stands there change."""
    shelf.body.instruct(OpenDock(ATV, ITEM, 20))
    shelf.says(KIND.ARRIVED, 20)
    shelf.body.instruct(CloseDock(ATV))
    return shelf.level - 40


@pytest.mark.parametrize(("by_vehicles", "change"), [(False, 20), (True, 0)])
def test_what_arrives_while_a_vehicle_stands_there_is_its_load_only_where_vehicles_refill(
    by_vehicles: bool, change: int
) -> None:
    assert by_hand(Shelf(refilled_by_vehicles=by_vehicles)) == change


def test_what_is_taken_by_hand_while_a_vehicle_brings_is_not_the_number_of_its_load() -> None:
    shelf = Shelf(refilled_by_vehicles=True)
    shelf.body.instruct(OpenDock(ATV, ITEM, 10))
    assert shelf.says(KIND.TAKEN, 6) == (None, "")
    brought = Book(ATV, ITEM, 10, task="S1-1", epoch=1)
    shelf.body.instruct(brought)
    assert (shelf.level, shelf.moved()) == (44, [10, -6])
    assert shelf.body.sense().loads == (UnconfirmedLoad(ATV, ITEM, 10, goes=False),)
    shelf.begin()
    shelf.body.instruct(brought)
    assert shelf.level == 44


@pytest.mark.parametrize("kind", [KIND.MADE, KIND.SCRAPPED])
def test_nobody_makes_anything_there(kind: MachineCommandKind) -> None:
    shelf = Shelf()
    assert shelf.says(kind, 1) == (REFUSED.NOT_SUPPORTED, "")
    assert shelf.level == 40


def test_words_of_a_material_that_is_not_kept_there_or_of_no_pieces_are_refused() -> None:
    shelf = Shelf()
    shelf.body.instruct(Word("maria/x", KIND.ARRIVED, "gold", 1))
    assert shelf.reports[-1] == WordTaken("maria/x", REFUSED.NOT_HANDLED)
    assert shelf.says(KIND.ARRIVED, 0) == (REFUSED.QUANTITY_OUT_OF_RANGE, "")
    assert shelf.says(KIND.ARRIVED, -3) == (REFUSED.QUANTITY_OUT_OF_RANGE, "")
    assert shelf.level == 40


def test_what_was_damaged_has_to_be_counted_and_no_count_is_doubted_then() -> None:
    shelf = Shelf()
    shelf.kept = DAMAGED_STORE
    shelf.begin()
    assert ITEM in shelf.body.sense().uncounted
    assert shelf.says(KIND.ARRIVED, 3) == (None, "")
    assert ITEM in shelf.body.sense().uncounted
    shelf.begin()
    assert shelf.says(KIND.STOCK_IS, 40) == (None, "")
    others = {line.material for line in SPEC.stocks} - {ITEM}
    assert (set(shelf.body.sense().uncounted), shelf.level) == (others, 40)
    assert shelf.says(KIND.STOCK_IS, 400) == (REFUSED.UNLIKELY, "40")


def test_whose_word_is_awaited_is_told_so_that_an_agent_without_notes_can_end_it() -> None:
    shelf = Shelf()
    shelf.body.instruct(OpenDock(ATV, ITEM, 12))
    assert shelf.body.sense().gone == ()
    shelf.body.instruct(CloseDock(ATV))
    assert (shelf.body.sense().opened, shelf.body.sense().gone) == ((), (ATV,))
    assert shelf.says(KIND.STOCK_IS, 40) == (REFUSED.DOCK_OPEN, "")
    shelf.body.instruct(CloseDock(ATV))
    assert shelf.body.sense().gone == ()
    assert shelf.says(KIND.STOCK_IS, 40) == (None, "")
