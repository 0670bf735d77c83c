"""What others fetch from a machine whose body does not count is booked out once, when their vehicle says that it has it."""

from __future__ import annotations

from effects import committed, instructed, listening, sent
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from spoken import rhb

from dray.body import Book, OpenDock
from dray.messages import Docked, Phase, StockAsked, StockFreed, StockReserved, StockShort
from dray.messages.keys import Keys
from dray.plant.file.file import shipped_plant
from dray.protocol.runtime.events import Effect

PLANT = shipped_plant("levels")
TASK, CART = "PRESS1-1", "CART1"
OUT = Book(CART, "shaft", -6, task=TASK, epoch=1)


def at_the_dock(rig: MachineRig | None = None) -> MachineRig:
    """A lathe with 12 shafts that no goal of its own wants; a cart stands there to fetch six of them for a press."""
    rig = rig or BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT)
    rig.start()
    assert sent(rig.on_message("PRESS1", StockAsked(TASK, 1, "shaft", 6)), StockReserved)
    assert instructed(rig.on_message(CART, Docked(TASK, 1, "LATHE1", "shaft", 6)), OpenDock)
    return rig


def beats(rig: MachineRig, phase: Phase, *, task: str = TASK, epoch: int = 1) -> list[Effect]:
    """The cart tells what it does."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(CART, 1000 + int(rig.now_s), rig.now_s, task=task, coordinator="PRESS1")
    assert beat.task is not None
    return rig.on_message(CART, replace(beat, task=replace(beat.task, phase=phase, epoch=epoch)))


def lies_there(rig: MachineRig) -> tuple[int, int | None]:
    """Shafts, and how many of them are spare, by its heartbeat."""
    rig.run(rig.now_s + 11.0)
    [level] = [each for each in rig.stock_told()[1] if each.item == "shaft"]
    return level.level, level.spare


def test_a_load_is_booked_out_once_its_vehicle_has_it() -> None:
    rig = at_the_dock()
    assert instructed(beats(rig, Phase.LOADING), Book) == []
    assert instructed(beats(rig, Phase.CARRYING), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    assert instructed(beats(rig, Phase.UNLOADING), Book) == []
    assert lies_there(rig) == (6, 6)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 6)), StockReserved)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-2", 1, "shaft", 1)), StockShort)


def test_the_vehicle_is_listened_to_from_the_dock_until_it_has_told() -> None:
    rig, key = at_the_dock(), Keys(PLANT.id).atv_heartbeat(CART)
    assert key in listening(rig.all)
    beats(rig, Phase.CARRYING)
    assert key not in listening(rig.all)


def test_a_vehicle_that_leaves_without_the_load_has_taken_nothing() -> None:
    rig = at_the_dock()
    beats(rig, Phase.APPROACHING, task="PRESS2-7")
    assert instructed(beats(rig, Phase.CARRYING), Book) == []
    assert lies_there(rig) == (12, 12)


def test_another_epoch_of_its_task_is_another_load() -> None:
    rig = at_the_dock()
    assert instructed(beats(rig, Phase.CARRYING, epoch=2), Book) == []


def test_a_load_that_was_given_back_while_it_was_taken_is_booked_out_all_the_same() -> None:
    rig = at_the_dock()
    rig.on_message("PRESS1", StockFreed(TASK))
    assert instructed(beats(rig, Phase.RETURNING), Book) == [OUT]


def test_a_life_that_begins_while_a_vehicle_loads_books_its_load_out() -> None:
    first = at_the_dock()
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    rig.memory = committed(first.all)
    rig.start()
    assert instructed(beats(rig, Phase.CARRYING), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    assert lies_there(rig) == (6, 6)


def test_what_was_booked_before_a_kill_and_is_told_again_takes_nothing_twice() -> None:
    first = at_the_dock()
    # It was killed after its body had booked: the stock tells of it, its own notes do not.
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 6}, plant=PLANT, incarnation=2)
    rig.memory, rig.seq = committed(first.all), 1
    rig.start()
    beats(rig, Phase.CARRYING)
    rig.seq, rig.stock["shaft"] = 0, 12
    rig.stocked("shaft", -6, CART)  # The body answers as it did before, with the number of then.
    assert lies_there(rig) == (6, 6)


def test_a_body_that_counts_is_told_nothing() -> None:
    rig = at_the_dock(MachineRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT))
    assert instructed(beats(rig, Phase.CARRYING), Book) == []
