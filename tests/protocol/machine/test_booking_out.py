"""What others fetch from a machine whose body does not count is booked out once, when their vehicle says that it has it."""

from __future__ import annotations

import pytest
from effects import committed, instructed, listening, sent
from m7 import NO_HOUSINGS, docked, handover, m7, supplied_by
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from spoken import rhb

from dray.body import Book, CloseDock, DockReady, OpenDock
from dray.messages import (
    Docked,
    DockOpened,
    Phase,
    Reason,
    Resigned,
    Role,
    StockAsked,
    StockFreed,
    StockReserved,
    StockShort,
)
from dray.messages.keys import Keys
from dray.plant.file.file import shipped_plant
from dray.protocol.runtime.events import Effect, Instruct

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


def beats(
    rig: MachineRig, phase: Phase, *, task: str = TASK, epoch: int = 1, aboard: str = "", node: str = ""
) -> list[Effect]:
    """The cart tells what it does."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(CART, 1000 + int(rig.now_s), rig.now_s, task=task, coordinator="PRESS1")
    assert beat.task is not None
    beat = replace(beat, load=aboard, load_quantity=6 if aboard else 0, node=node or beat.node)
    return rig.on_message(CART, replace(beat, task=replace(beat.task, phase=phase, epoch=epoch)))


def lies_there(rig: MachineRig) -> tuple[int, int | None]:
    """Shafts, and how many of them are spare, by its heartbeat."""
    rig.run(rig.now_s + 11.0)
    [level] = [each for each in rig.reported_stock()[1] if each.item == "shaft"]
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


def test_a_vehicle_that_leaves_for_another_task_with_such_a_load_on_board_has_taken_it() -> None:
    rig = at_the_dock()
    assert instructed(beats(rig, Phase.APPROACHING, task="PRESS2-7", aboard="bar"), Book) == []
    rig = at_the_dock()
    assert instructed(beats(rig, Phase.APPROACHING, task="PRESS2-7", aboard="shaft"), Book) == [OUT]


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


def test_what_was_fetched_is_told_again_by_the_next_life_until_the_body_has_answered() -> None:
    first = at_the_dock()
    assert instructed(beats(first, Phase.CARRYING), Book) == [OUT]
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    rig.memory = committed(first.all)
    assert instructed(rig.start(), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    third = BlindRig("LATHE1", {"bar": 60, "shaft": 6}, plant=PLANT, incarnation=3)
    third.memory = committed(rig.all)
    assert instructed(third.start(), Book) == []


def test_a_body_that_counts_is_told_nothing() -> None:
    rig = at_the_dock(MachineRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT))
    assert instructed(beats(rig, Phase.CARRYING), Book) == []


def test_a_vehicle_that_comes_for_a_second_load_unheard_has_taken_the_first() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 4)), StockReserved)
    effects = rig.on_message(CART, Docked("PRESS2-1", 1, "LATHE1", "shaft", 4))
    told = [effect.instruction for effect in effects if isinstance(effect, Instruct)]
    assert told == [OUT, OpenDock(CART, "shaft", 4)]  # A body shuts its dock when it books.
    second = Book(CART, "shaft", -4, task="PRESS2-1", epoch=1)
    assert instructed(beats(rig, Phase.CARRYING, task="PRESS2-1"), Book) == [second]


def test_a_vehicle_that_was_heard_at_the_dock_and_asks_for_another_load_has_not_taken_the_first() -> None:
    rig = at_the_dock()
    beats(rig, Phase.LOADING)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 4)), StockReserved)
    assert instructed(rig.on_message(CART, Docked("PRESS2-1", 1, "LATHE1", "shaft", 4)), Book) == []


def stands_there(rig: MachineRig, *, aboard: str = "", node: str = PLANT.node_of("LATHE1")) -> list[Effect]:
    """The cart tells that it has no task."""
    rig.run(rig.now_s + 1.0)
    beat = replace(rhb(CART, 1000 + int(rig.now_s), rig.now_s), node=node)
    return rig.on_message(CART, replace(beat, task=None, load=aboard, load_quantity=6 if aboard else 0))


@pytest.mark.parametrize("silent_s", [0.0, 60.0], ids=["heard", "not-heard"])
def test_a_vehicle_that_stands_there_without_a_task_may_still_be_loading(silent_s: float) -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + silent_s)
    assert instructed(stands_there(rig), Book) == []
    assert instructed(stands_there(rig, aboard="shaft"), Book) == [OUT]


def test_a_vehicle_that_has_stood_there_without_a_task_and_leaves_empty_has_taken_nothing() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    stands_there(rig)
    effects = stands_there(rig, node="elsewhere")
    assert (instructed(effects, Book), sent(effects, StockReserved)) == ([], [])
    assert instructed(stands_there(rig, aboard="shaft", node="elsewhere"), Book) == []


# --- at a dock that opens later ---


def before_a_shut_dock() -> MachineRig:
    """The cart stands before the lathe's dock, which the body has not opened yet."""
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT)
    rig.answers = True
    return at_the_dock(rig)


def opens(rig: MachineRig) -> None:
    """The body has opened the dock."""
    assert sent(rig.report(DockReady(vehicle=CART)), DockOpened)


@pytest.mark.parametrize("aboard", ["", "shaft"])
def test_a_vehicle_that_ends_its_task_before_the_dock_opens_takes_nothing(aboard: str) -> None:
    rig = before_a_shut_dock()
    stands_there(rig)
    opens(rig)
    stands_there(rig)
    rig.run(rig.now_s + 60.0)
    effects = stands_there(rig, aboard=aboard, node="elsewhere")
    assert (instructed(effects, Book), sent(effects, StockReserved)) == ([], [])
    assert instructed(stands_there(rig, aboard="shaft", node="elsewhere"), Book) == []


def test_the_next_life_knows_that_a_vehicle_has_ended_its_task_before_the_dock_opened() -> None:
    first = before_a_shut_dock()
    stands_there(first)
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    rig.memory, rig.now_s, rig.answers, rig.opened = committed(first.all), first.now_s, True, (CART,)
    rig.start()
    rig.run(rig.now_s + 60.0)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 4)), StockReserved)
    effects = rig.on_message(CART, Docked("PRESS2-1", 1, "LATHE1", "shaft", 4))
    assert (instructed(effects, Book), len(instructed(effects, OpenDock))) == ([], 1)


def test_the_dock_is_shut_for_a_vehicle_that_was_let_in_and_is_elsewhere_for_another_task() -> None:
    rig = before_a_shut_dock()
    opens(rig)
    beats(rig, Phase.LOADING)
    late = replace(rhb(CART, 1, rig.now_s), node="elsewhere", task=None)
    assert instructed(rig.on_message(CART, late), CloseDock) == []
    effects = stands_there(rig, node="elsewhere")
    assert instructed(effects, CloseDock) == [CloseDock(vehicle=CART)]
    assert instructed(effects, Book) == []


def test_the_dock_does_not_open_for_a_vehicle_that_has_waited_for_it_and_is_elsewhere() -> None:
    rig = before_a_shut_dock()
    stands_there(rig)
    effects = stands_there(rig, node="elsewhere")
    assert instructed(effects, CloseDock) == [CloseDock(vehicle=CART)]
    assert sent(rig.report(DockReady(vehicle=CART)), DockOpened) == []


def test_a_vehicle_whose_heartbeat_from_elsewhere_has_come_late_asks_again_and_is_let_in() -> None:
    rig = before_a_shut_dock()
    late = replace(rhb(CART, 1, rig.now_s), node="elsewhere", task=None)
    assert instructed(rig.on_message(CART, late), CloseDock) == [CloseDock(vehicle=CART)]
    assert instructed(rig.on_message(CART, Docked(TASK, 1, "LATHE1", "shaft", 6)), OpenDock)
    opens(rig)


def test_a_vehicle_that_names_its_task_again_may_load_after_all() -> None:
    rig = before_a_shut_dock()
    stands_there(rig)  # A heartbeat of before, which has come late.
    beats(rig, Phase.LOADING)
    opens(rig)
    rig.run(rig.now_s + 60.0)
    assert sent(stands_there(rig, node="elsewhere"), StockReserved, to="PRESS1")


def test_a_vehicle_that_asks_again_may_load_after_all() -> None:
    rig = before_a_shut_dock()
    stands_there(rig)
    rig.on_message(CART, Docked(TASK, 1, "LATHE1", "shaft", 6))
    opens(rig)
    rig.run(rig.now_s + 60.0)
    assert sent(stands_there(rig, node="elsewhere"), StockReserved, to="PRESS1")


@pytest.mark.parametrize("is_restarted", [False, True])
def test_a_vehicle_that_was_let_in_and_asks_again_may_load_still_when_it_has_no_task_any_more(
    *, is_restarted: bool
) -> None:
    rig = before_a_shut_dock()
    opens(rig)
    if is_restarted:
        second = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
        second.memory, second.answers, second.opened = committed(rig.all), True, (CART,)
        second.start()
        rig = second
    # Its body loads while its agent is started again, and is released.
    rig.on_message(CART, Docked(TASK, 1, "LATHE1", "shaft", 6))
    stands_there(rig)
    rig.run(rig.now_s + 60.0)
    assert instructed(stands_there(rig, aboard="shaft", node="elsewhere"), Book) == [OUT]


def test_a_vehicle_that_a_life_without_notes_finds_let_in_may_load_still_when_it_asks_again() -> None:
    first = before_a_shut_dock()
    opens(first)
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    rig.answers, rig.opened, rig.now_s = True, (CART,), first.now_s
    rig.start()
    # Its body loads while its agent is started again, and is released before the dock is ready once more.
    rig.on_message("PRESS1", StockAsked(TASK, 1, "shaft", 6))
    assert instructed(rig.on_message(CART, Docked(TASK, 1, "LATHE1", "shaft", 6)), OpenDock)
    stands_there(rig)
    rig.run(rig.now_s + 60.0)
    assert instructed(stands_there(rig, aboard="shaft", node="elsewhere"), Book) == [OUT]


# --- a life without notes, whose body remembers what it has let in ---


def without_notes(item: str = "shaft") -> MachineRig:
    """The lathe's agent has lost its notes while the cart was let in."""
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    rig.answers, rig.opened, rig.let_in = True, (CART,), OpenDock(CART, item, 6)
    rig.start()
    return rig


DOCK = PLANT.node_of("LATHE1")
UNNOTED = Book(CART, "shaft", -6, task="", epoch=2)


def test_in_doubt_a_life_without_notes_books_out_what_its_body_has_let_a_vehicle_take() -> None:
    rig = without_notes()
    effects = stands_there(rig, node="elsewhere")
    assert instructed(effects, Book) == [UNNOTED]
    rig.stocked("shaft", -6, CART)
    assert lies_there(rig) == (6, 6)


def test_a_life_without_notes_books_out_what_the_vehicle_leaves_with() -> None:
    rig = without_notes()
    assert instructed(beats(rig, Phase.LOADING, node=DOCK), Book) == []
    assert instructed(beats(rig, Phase.LOADING, node=DOCK), Book) == []
    assert instructed(beats(rig, Phase.CARRYING, node=DOCK, aboard="shaft"), Book) == [UNNOTED]


def test_what_leaves_with_its_task_s_name_is_booked_out_once_though_the_body_remembers_it() -> None:
    rig = without_notes()
    beat = rhb(CART, 1000, rig.now_s, task=TASK, coordinator="PRESS1")
    assert beat.task is not None
    carries = replace(beat.task, phase=Phase.CARRYING, item="shaft", quantity=6)
    beat = replace(beat, task=carries, node=DOCK, load="shaft", load_quantity=6)
    assert instructed(rig.on_message(CART, beat), Book) == [UNNOTED]
    assert instructed(rig.on_message(CART, replace(beat, seq=1001)), Book) == []
    rig.stocked("shaft", -6, CART)
    assert instructed(rig.on_message(CART, replace(beat, seq=1002)), Book) == []


def test_a_life_without_notes_books_nothing_out_for_a_vehicle_that_it_saw_leave_without() -> None:
    rig = without_notes()
    stands_there(rig)
    assert instructed(stands_there(rig, node="elsewhere"), Book) == []
    assert instructed(stands_there(rig, node="elsewhere", aboard="shaft"), Book) == []


def test_a_life_without_notes_books_no_material_out_that_a_vehicle_may_have_brought() -> None:
    assert instructed(stands_there(without_notes("bar"), node="elsewhere"), Book) == []


def test_who_asks_a_life_without_notes_again_has_not_taken_its_load() -> None:
    rig = without_notes()
    rig.on_message("PRESS1", StockAsked(TASK, 1, "shaft", 6))
    assert instructed(rig.on_message(CART, Docked(TASK, 1, "LATHE1", "shaft", 6)), Book) == []


def test_the_life_after_one_without_notes_goes_on_with_what_that_followed() -> None:
    first = without_notes()
    stands_there(first)
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=3)
    rig.answers, rig.opened, rig.let_in, rig.memory = True, (CART,), first.let_in, committed(first.all)
    rig.now_s = first.now_s
    rig.start()
    assert lies_there(rig) == (12, 12)
    assert instructed(stands_there(rig, node="elsewhere"), Book) == [UNNOTED]


def test_what_a_vehicle_has_on_board_before_the_dock_opens_is_not_from_here() -> None:
    rig = before_a_shut_dock()
    assert instructed(stands_there(rig, aboard="shaft"), Book) == []
    opens(rig)
    # It stands here still, and has such a load: in doubt it is booked out.
    assert instructed(stands_there(rig, aboard="shaft"), Book) == [OUT]


# --- after a time in which the vehicle was not heard ---


def after_a_trip(*, told_by: str = "PRESS1") -> MachineRig:
    """The lathe's agent was down while the cart has loaded; it works at something else by now."""
    first = at_the_dock()
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    rig.memory = committed(first.all)
    rig.start()
    effects = beats(rig, Phase.APPROACHING, task="PRESS2-7")
    assert sent(effects, StockReserved, to=told_by) == [StockReserved(TASK, 1, "shaft", 6)]
    assert instructed(effects, Book) == []
    return rig


def test_a_load_that_was_fetched_while_the_agent_was_down_is_booked_out() -> None:
    rig = after_a_trip()
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    assert lies_there(rig) == (6, 6)


def test_a_load_that_was_not_fetched_while_the_agent_was_down_lies_there_still() -> None:
    rig = after_a_trip()
    assert instructed(rig.on_message("PRESS2", StockFreed(TASK, fetched=True)), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK)), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == []
    assert lies_there(rig)[0] == 12


def test_a_load_of_an_earlier_epoch_is_booked_out_while_its_task_goes_on_and_keeps_what_was_promised() -> (
    None
):
    rig = after_a_trip()
    assert sent(rig.on_message("PRESS1", StockAsked(TASK, 2, "shaft", 6)), StockReserved)
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True, epoch=2)), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True, epoch=1)), Book) == [OUT]
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 7)), StockShort)


def test_a_load_that_an_earlier_carrier_has_not_fetched_stays_promised_to_its_task() -> None:
    rig = after_a_trip()
    assert sent(rig.on_message("PRESS1", StockAsked(TASK, 2, "shaft", 6)), StockReserved)
    for _ in range(2):
        assert instructed(rig.on_message("PRESS1", StockFreed(TASK, epoch=1)), Book) == []
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 7)), StockShort)


def elsewhere(rig: MachineRig, *, aboard: str = "shaft", left_empty: str = "") -> list[Effect]:
    """The cart works for another press."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(CART, 1000 + int(rig.now_s), rig.now_s, task="PRESS2-7", coordinator="PRESS2")
    beat = replace(beat, node="elsewhere", left_empty=left_empty)
    return rig.on_message(CART, replace(beat, load=aboard, load_quantity=6 if aboard else 0))


@pytest.mark.parametrize("aboard", ["", "shaft"])
def test_a_vehicle_that_left_empty_after_it_had_lost_its_memory_here_has_not_fetched_its_load(
    aboard: str,
) -> None:
    first = at_the_dock()
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    rig.memory, rig.now_s = committed(first.all), first.now_s
    rig.start()
    effects = elsewhere(rig, aboard=aboard, left_empty=DOCK)
    assert (instructed(effects, Book), sent(effects, StockReserved)) == ([], [])
    assert instructed(elsewhere(rig), Book) == []
    assert lies_there(rig)[0] == 12


def test_a_vehicle_that_says_so_after_its_coordinator_was_asked_has_not_fetched_its_load() -> None:
    rig = after_a_trip()
    assert instructed(elsewhere(rig, aboard="", left_empty=DOCK), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == []


def test_a_life_without_notes_knows_that_a_vehicle_without_memory_has_left_empty() -> None:
    assert instructed(elsewhere(without_notes(), left_empty=DOCK), Book) == []


def test_what_a_vehicle_has_on_board_after_it_was_heard_elsewhere_without_is_not_from_here() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    assert sent(elsewhere(rig, aboard=""), StockReserved, to="PRESS1")
    assert instructed(elsewhere(rig), Book) == []
    # It passes by, and stands here without a task: its body has not gone on loading.
    assert instructed(stands_there(rig, aboard="shaft"), Book) == []
    # Neither does the next life take it for that.
    second = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT, incarnation=2)
    second.memory, second.now_s = committed(rig.all), rig.now_s
    second.start()
    effects = elsewhere(second)
    assert (instructed(effects, Book), len(sent(effects, StockReserved, to="PRESS1"))) == ([], 1)
    assert instructed(second.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == [OUT]


def test_a_vehicle_that_was_heard_elsewhere_and_names_the_task_with_its_load_has_fetched_it() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    elsewhere(rig, aboard="")
    assert instructed(beats(rig, Phase.CARRYING), Book) == [OUT]


def test_a_vehicle_that_was_heard_elsewhere_and_is_let_in_again_may_take_a_load() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    elsewhere(rig, aboard="")
    rig.on_message(CART, Docked(TASK, 1, "LATHE1", "shaft", 6))
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == []  # A late answer.
    assert instructed(stands_there(rig, aboard="shaft"), Book) == [OUT]


def test_the_coordinator_is_asked_until_it_answers_and_no_oftener_than_it_needs() -> None:
    rig = after_a_trip()
    asked = [
        each
        for _ in range(25)
        for each in sent(beats(rig, Phase.APPROACHING, task="PRESS2-7"), StockReserved)
    ]
    assert len(asked) == 2


def test_a_vehicle_that_was_not_heard_for_a_while_may_have_fetched_it() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    effects = beats(rig, Phase.APPROACHING, task="PRESS2-7")
    assert sent(effects, StockReserved, to="PRESS1")
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == [OUT]


@pytest.mark.parametrize(
    ("epoch", "known"),
    [(1, True), (0, False), (2, False)],
    ids=["its epoch", "the epoch of an earlier carrier", "the epoch of one who took over unheard"],
)
def test_a_coordinator_that_is_asked_says_whether_the_load_was_fetched_or_may_have_been(
    epoch: int, *, known: bool
) -> None:
    rig = supplied_by("ATV2")
    rig.on_message("ATV2", docked())
    rig.on_message("ATV2", handover())
    said = rig.on_message("S1", StockReserved("M7-1", epoch, "housing", 24))
    assert sent(said, StockFreed, to="S1") == [StockFreed("M7-1", fetched=True, known=known)]


def test_a_coordinator_whose_task_goes_on_says_that_an_earlier_carrier_may_have_fetched_the_load() -> None:
    rig = supplied_by("ATV2")
    rig.on_message("ATV2", Resigned("M7-1", 1, Role.PRIMARY, Reason.HAS_WORK))
    for _ in range(2):
        said = rig.on_message("S1", StockReserved("M7-1", 1, "housing", 24))
        assert sent(said, StockFreed, to="S1") == [StockFreed("M7-1", fetched=True, epoch=1)]
    assert sent(rig.on_message("S1", StockReserved("M7-1", 2, "housing", 24)), StockFreed) == []


def test_a_coordinator_that_has_withdrawn_a_load_which_somebody_carries_does_not_say_that_it_lies_there() -> (
    None
):
    rig = supplied_by("ATV2")
    said = rig.on_message("ATV2", Resigned("M7-1", 1, Role.PRIMARY, Reason.DOCK_HELD, short="S1"))
    freed = sent(said, StockFreed)
    assert freed
    assert all(each.fetched for each in freed if each.task == "M7-1")


def test_a_coordinator_that_remembers_nothing_does_not_say_that_the_load_lies_there() -> None:
    rig = supplied_by("ATV2")
    said = rig.on_message("S1", StockReserved("M7-99", 1, "housing", 24))
    assert sent(said, StockFreed, to="S1") == [StockFreed("M7-99", fetched=True)]


def test_a_load_for_which_nobody_was_ever_bound_lies_there_still() -> None:
    rig = m7(NO_HOUSINGS, goal=24)
    for station in ("S1", "S2", "S6", "S7"):
        rig.on_message(station, StockShort("M7-1", 1, "housing", 0))
    said = rig.on_message("S1", StockReserved("M7-1", 1, "housing", 24))
    assert sent(said, StockFreed, to="S1") == [StockFreed("M7-1")]
